#include "calibrated/verdict.h"
namespace corrsel::core {
Verdict decideMotion(const VerdictInput& in) { Verdict v; v.motion = in.pose ? Motion::kGeneral : Motion::kNone; if (in.pose) v.pose = *in.pose; return v; }
}
