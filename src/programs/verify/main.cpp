// corrsel_verify: verifies the pairs of a whole database of images and matches.

#include "programs/verify/run.h"

int main(int argc, char** argv) { return corrsel::runVerify({argv + 1, argv + argc}); }
