#include "corrsel/selectors/adalam.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

#include "base/deadline.h"
#include "base/text.h"
#include "kernels/kernels.h"
#include "points/point_cells.h"
#include "points/point_groups.h"
#include "search/ordering.h"
#include "selectors/parts/degenerate_input.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 6;
constexpr double kPi = 3.14159265358979323846;
// Votes that make maps, and votes at most.
constexpr std::size_t kSampled = 16, kMaxVotes = 1024;
// Determinants below this share of what the lengths allow belong to points on a line through the seed.
constexpr float kMinDeterminant = 1e-3F;
// What the slots behind the last vote hold.
constexpr float kFarAway = 1e9F;
// From these values on, frames are not compared.
constexpr double kAnyRotation = 180, kAnyScaleChange = 10;

/// A match in the order of the grid.
struct Member {
  float left_x, left_y, right_x, right_y;
  float cosine, sine, scale;  // of the local map; the scale as a logarithm
  std::uint32_t rank, row;
};

/// A match with a vote.
struct Vote {
  std::uint32_t rank, member;
};

using Map = std::array<float, 4>;

/// Which matches belong to the neighbourhood of a seed.
struct Reach {
  double left, right;  // rho, px
  float min_cosine, max_log_scale;
};

/// Rotation and scale of the map between two frames; NaN where there is none.
void setFrames(const AffineFrame& left, const AffineFrame& right, Member& member) {
  const double a = left[0], b = left[1], c = left[3], d = left[4], determinant = a * d - b * c;
  const double p = right[0], q = right[1], r = right[3], s = right[4];
  // right * adjugate(left), which differs from the map by the factor of the determinant.
  const double sign = determinant < 0 ? -1 : 1;
  const double real = sign * (p * d - q * c + s * a - r * b),
               imaginary = sign * (r * d - s * c - q * a + p * b);
  const double length = std::hypot(real, imaginary);
  member.cosine = static_cast<float>(real / length);
  member.sine = static_cast<float>(imaginary / length);
  member.scale = static_cast<float>(0.5 * std::log(std::abs((p * s - q * r) / determinant)));
}

/// Memory that is kept between calls.
struct AdalamMemory {
  Ordering ordering;
  std::vector<std::uint32_t> shuffled, by_quality;
  PointGroups left_groups, right_groups;

  std::vector<float> ranked_x, ranked_y;               // left points, best first
  PointCells cells;                                    // the same
  std::vector<Member> members;                         // cell by cell, the best of a cell first
  std::vector<float> framed[7];                        // of the members, as in FramedMatches
  std::vector<std::uint32_t> left_group, right_group;  // of the members
  std::vector<std::uint32_t> seeds;                    // members

  // One seed.
  std::vector<std::uint32_t> around, found;
  std::vector<std::uint64_t> best_left, best_right;  // per group: stamp and rank
  std::vector<Vote> votes;
  std::vector<float> left_x, left_y, right_x, right_y;  // of the votes, relative to the seed
  std::vector<float> limits;                            // squared error that k votes may have

  std::vector<float> score;
};

/// Sorts the matches into cells, best first.
void layOut(const Correspondences& m, double cell, bool frames, AdalamMemory& work) {
  const std::size_t n = m.size();
  work.ranked_x.resize(n);
  work.ranked_y.resize(n);
  for (std::uint32_t rank = 0; rank < n; ++rank) {
    const std::uint32_t row = work.shuffled[work.by_quality[rank]];
    work.ranked_x[rank] = m.left_x[row];
    work.ranked_y[rank] = m.left_y[row];
  }
  work.cells.build(work.ranked_x.data(), work.ranked_y.data(), n,
                   CellGrid::covering(0, 0, m.left_size.width, m.left_size.height, cell));
  work.members.resize(n);
  work.left_group.resize(n);
  work.right_group.resize(n);
  for (std::uint32_t rank = 0; rank < n; ++rank) {
    const std::uint32_t row = work.shuffled[work.by_quality[rank]];
    const std::uint32_t place = work.cells.slotOf()[rank];
    Member& member = work.members[place];
    member = {m.left_x[row], m.left_y[row], m.right_x[row], m.right_y[row], 1, 0, 0, rank, row};
    if (frames) setFrames(m.left_frame[row], m.right_frame[row], member);
    work.left_group[place] = work.left_groups.of[row];
    work.right_group[place] = work.right_groups.of[row];
  }
  for (std::vector<float>& column : work.framed) column.resize(n + FramedMatches::kMultiple);
  for (std::size_t i = 0; i < n; ++i) {
    const Member& o = work.members[i];
    const float values[] = {o.left_x, o.left_y, o.right_x, o.right_y, o.cosine, o.sine, o.scale};
    for (std::size_t c = 0; c < std::size(values); ++c) work.framed[c][i] = values[c];
  }
  work.found.resize(n + FramedMatches::kMultiple);
}

float squaredDistance(float ax, float ay, float bx, float by) {
  return (ax - bx) * (ax - bx) + (ay - by) * (ay - by);
}

/// Finds the seeds, best first.
void findSeeds(const Correspondences& m, double radius, double ratio, AdalamMemory& work) {
  const auto squared = static_cast<float>(radius * radius);
  work.seeds.clear();
  work.cells.visitCells([&](std::uint32_t candidate, std::uint32_t cell_end) {
    if (candidate == cell_end) return;
    const Member& best = work.members[candidate];
    if (ratio < 1 && !(m.distance[best.row] <= ratio * m.second_distance[best.row])) return;
    bool beaten = false;
    work.cells.visitRuns(
        best.left_x, best.left_y, radius, radius, [&](std::uint32_t begin, std::uint32_t end) {
          for (std::uint32_t j = begin; j < end && !beaten; ++j) {
            const Member& other = work.members[j];
            beaten = other.rank < best.rank &&
                     squaredDistance(other.left_x, other.left_y, best.left_x, best.left_y) < squared;
          }
        });
    if (!beaten) work.seeds.push_back(candidate);
  });
  std::sort(work.seeds.begin(), work.seeds.end(), [&work](std::uint32_t a, std::uint32_t b) {
    return work.members[a].rank < work.members[b].rank;
  });
}

/// Finds the matches around a seed, without itself.
void findNeighbourhood(std::uint32_t seed, const Reach& reach, AdalamMemory& work) {
  const Member& s = work.members[seed];
  const auto& c = work.framed;
  const FramedMatches matches = {c[0].data(), c[1].data(), c[2].data(), c[3].data(),
                                 c[4].data(), c[5].data(), c[6].data()};
  // Without frames, all maps are equal.
  const FramedReach limits = {s.left_x,
                              s.left_y,
                              s.right_x,
                              s.right_y,
                              s.cosine,
                              s.sine,
                              s.scale,
                              static_cast<float>(reach.left * reach.left),
                              static_cast<float>(reach.right * reach.right),
                              reach.min_cosine,
                              reach.max_log_scale};
  const auto around = kernels().affine.around;
  std::uint32_t* const found = work.found.data();
  std::size_t count = 0;
  work.cells.visitRuns(s.left_x, s.left_y, reach.left, reach.left,
                       [&](std::uint32_t begin, std::uint32_t end) {
                         count += around(matches, begin, end, limits, found + count);
                       });
  work.around.assign(found, std::remove(found, found + count, seed));
}

/// Chooses the votes: the best one of every point, and none at the points of the seed.
void chooseVotes(std::uint32_t seed, bool one_to_one, std::uint64_t stamp, AdalamMemory& work) {
  work.votes.clear();
  for (const std::uint32_t j : work.around) work.votes.push_back({work.members[j].rank, j});
  if (one_to_one) {
    for (const bool right : {true, false}) {
      const std::vector<std::uint32_t>& group = right ? work.right_group : work.left_group;
      std::vector<std::uint64_t>& best = right ? work.best_right : work.best_left;
      // A later stamp is larger, and so is a better rank after the subtraction.
      const auto value = [stamp](std::uint32_t rank) { return stamp << 32 | (0xFFFFFFFEU - rank); };
      best[group[seed]] = stamp << 32 | 0xFFFFFFFFU;
      for (const Vote& vote : work.votes) {
        std::uint64_t& known = best[group[vote.member]];
        known = std::max(known, value(vote.rank));
      }
      work.votes.erase(
          std::remove_if(work.votes.begin(), work.votes.end(),
                         [&](const Vote& vote) { return best[group[vote.member]] != value(vote.rank); }),
          work.votes.end());
    }
  }
  const auto better = [](const Vote& a, const Vote& b) { return a.rank < b.rank; };
  const auto keepBest = [&](std::size_t count) {
    if (work.votes.size() <= count) return;
    std::nth_element(work.votes.begin(), work.votes.begin() + static_cast<std::ptrdiff_t>(count),
                     work.votes.end(), better);
  };
  keepBest(kMaxVotes);
  // Not resize(), of which GCC 14 assumes that it makes the vector longer, and warns.
  if (work.votes.size() > kMaxVotes) work.votes.erase(work.votes.begin() + kMaxVotes, work.votes.end());
  keepBest(kSampled);
  std::sort(work.votes.begin(),
            work.votes.begin() + static_cast<std::ptrdiff_t>(std::min(work.votes.size(), kSampled)), better);
}

/// Displacements of the votes from the seed.
RelativeMatches relate(std::uint32_t seed, const Reach& reach, AdalamMemory& work) {
  constexpr std::size_t kMultiple = RelativeMatches::kMultiple;
  const std::size_t n = work.votes.size(), slots = (n + kMultiple - 1) / kMultiple * kMultiple;
  for (std::vector<float>* column : {&work.left_x, &work.left_y, &work.right_x, &work.right_y})
    column->resize(slots);
  const Member& s = work.members[seed];
  const auto left = static_cast<float>(1 / reach.left), right = static_cast<float>(1 / reach.right);
  for (std::size_t i = 0; i < n; ++i) {
    const Member& o = work.members[work.votes[i].member];
    work.left_x[i] = (o.left_x - s.left_x) * left;
    work.left_y[i] = (o.left_y - s.left_y) * left;
    work.right_x[i] = (o.right_x - s.right_x) * right;
    work.right_y[i] = (o.right_y - s.right_y) * right;
  }
  for (std::size_t i = n; i < slots; ++i) {
    work.left_x[i] = work.left_y[i] = 0;
    work.right_x[i] = work.right_y[i] = kFarAway;
  }
  return {work.left_x.data(), work.left_y.data(), work.right_x.data(), work.right_y.data(), slots};
}

/// The verification of maps around one seed.
class Verification {
 public:
  /// @param floor  smallest squared error
  Verification(const RelativeMatches& matches, std::size_t votes, double confidence, double floor,
               std::vector<float>& limits)
      : matches_(matches), votes_(votes), limits_(limits) {
    limits_.resize(votes + 1);
    for (std::size_t k = 0; k <= votes; ++k) {
      const double limit = static_cast<double>(k) / (confidence * static_cast<double>(votes));
      limits_[k] = limit >= floor ? static_cast<float>(limit) : -1.0F;
    }
  }

  /// The largest k so that k votes have at most the error that k votes may have. Falling limits find it: as
  /// many votes as are within the limit of a larger number are an upper bound.
  /// @param own    votes that do not count
  /// @return 0 if it is not above `known`
  std::size_t support(const Map& a, std::size_t own, std::size_t known) const {
    std::size_t k = votes_;
    for (;;) {
      const auto within = static_cast<std::size_t>(kernels_.count(matches_, a.data(), limits_[k]));
      const std::size_t fewer = within > own ? within - own : 0;
      if (fewer <= known) return 0;
      if (fewer >= k) return k;
      k = fewer;
    }
  }

  float limit(std::size_t k) const { return limits_[k]; }
  float squaredError(const Map& a, std::size_t i) const {
    const float x = matches_.left_x[i], y = matches_.left_y[i];
    const float ex = a[0] * x + a[1] * y - matches_.right_x[i],
                ey = a[2] * x + a[3] * y - matches_.right_y[i];
    return ex * ex + ey * ey;
  }

  /// The map of two votes. @return whether they determine one
  bool mapOf(std::size_t i, std::size_t j, Map& a) const {
    const RelativeMatches& m = matches_;
    const float xi = m.left_x[i], yi = m.left_y[i], xj = m.left_x[j], yj = m.left_y[j];
    const float determinant = xi * yj - xj * yi;
    const float lengths = (xi * xi + yi * yi) * (xj * xj + yj * yj);
    if (!(determinant * determinant > kMinDeterminant * kMinDeterminant * lengths)) return false;
    const float inverse = 1 / determinant;
    a = {(m.right_x[i] * yj - m.right_x[j] * yi) * inverse, (m.right_x[j] * xi - m.right_x[i] * xj) * inverse,
         (m.right_y[i] * yj - m.right_y[j] * yi) * inverse,
         (m.right_y[j] * xi - m.right_y[i] * xj) * inverse};
    return true;
  }

  /// Fits a map to the votes that agree with it. @return whether they determine one
  bool refit(float limit, Map& a) const {
    double xx = 0, xy = 0, yy = 0, ux = 0, uy = 0, vx = 0, vy = 0;
    for (std::size_t i = 0; i < votes_; ++i) {
      if (!(squaredError(a, i) <= limit)) continue;
      const double x = matches_.left_x[i], y = matches_.left_y[i], u = matches_.right_x[i],
                   v = matches_.right_y[i];
      xx += x * x, xy += x * y, yy += y * y;
      ux += u * x, uy += u * y, vx += v * x, vy += v * y;
    }
    const double determinant = xx * yy - xy * xy, trace = xx + yy;
    if (!(determinant > double{kMinDeterminant} * kMinDeterminant * trace * trace)) return false;
    a = {static_cast<float>((ux * yy - uy * xy) / determinant),
         static_cast<float>((uy * xx - ux * xy) / determinant),
         static_cast<float>((vx * yy - vy * xy) / determinant),
         static_cast<float>((vy * xx - vx * xy) / determinant)};
    return true;
  }

 private:
  const RelativeMatches& matches_;
  std::size_t votes_;
  std::vector<float>& limits_;
  const AffineKernels& kernels_ = kernels().affine;
};

/// Whether both singular values are within [1 / max_stretch, max_stretch].
bool isStretchedWithin(const Map& a, double max_stretch) {
  const double p = a[0], q = a[1], r = a[2], s = a[3];
  const double squares = p * p + q * q + r * r + s * s, determinant = std::abs(p * s - q * r);
  const double root = std::sqrt(std::max(0.0, squares * squares - 4 * determinant * determinant));
  const double largest = std::sqrt((squares + root) / 2);
  return largest <= max_stretch && determinant >= largest / max_stretch;
}

/// The map with the largest support. @return its support; 0 if there is none
std::size_t findMap(const Verification& verification, std::size_t votes, int samples, Map& best) {
  constexpr std::size_t kOwn = 2;
  std::size_t support = 0;
  int tried = 0;
  const std::size_t sampled = std::min(votes, kSampled);
  for (std::size_t i = 1; i < sampled; ++i) {
    for (std::size_t j = 0; j < i && tried < samples; ++j, ++tried) {
      Map a;
      if (!verification.mapOf(i, j, a)) continue;
      const std::size_t k = verification.support(a, kOwn, support);
      if (k == 0) continue;
      support = k;
      best = a;
    }
  }
  return support;
}

/// Selects the matches around a seed that agree with its map.
void verify(std::uint32_t seed, const Reach& reach, const AdalamOptions& options, std::uint64_t stamp,
            AdalamMemory& work) {
  findNeighbourhood(seed, reach, work);
  if (work.around.size() < static_cast<std::size_t>(options.min_members)) return;
  chooseVotes(seed, options.one_to_one, stamp, work);
  const std::size_t votes = work.votes.size();
  if (votes < static_cast<std::size_t>(options.min_members)) return;
  const RelativeMatches relative = relate(seed, reach, work);
  const double floor = std::pow(options.min_error / reach.right, 2);
  const Verification verification(relative, votes, options.confidence, floor, work.limits);
  Map a;
  std::size_t k = findMap(verification, votes, options.samples, a);
  if (k == 0 || !verification.refit(verification.limit(k), a) || !isStretchedWithin(a, options.max_stretch))
    return;
  k = verification.support(a, 0, 0);
  if (k == 0) return;
  double largest = floor;
  for (std::size_t i = 0; i < votes; ++i) {
    const float error = verification.squaredError(a, i);
    if (error <= verification.limit(k)) largest = std::max(largest, double{error});
  }
  const double c = static_cast<double>(k) / (static_cast<double>(votes) * std::max(largest, 1e-12));
  if (!(c >= options.confidence && static_cast<double>(k) * (1 - 1 / c) >= options.min_members)) return;
  const auto score = static_cast<float>(std::log10(c));
  const Member& s = work.members[seed];
  const auto left = static_cast<float>(1 / reach.left), right = static_cast<float>(1 / reach.right);
  work.score[s.row] = std::max(work.score[s.row], score);
  for (const std::uint32_t j : work.around) {
    const Member& o = work.members[j];
    const float x = (o.left_x - s.left_x) * left, y = (o.left_y - s.left_y) * left;
    const float ex = a[0] * x + a[1] * y - (o.right_x - s.right_x) * right;
    const float ey = a[2] * x + a[3] * y - (o.right_y - s.right_y) * right;
    if (ex * ex + ey * ey <= verification.limit(k)) work.score[o.row] = std::max(work.score[o.row], score);
  }
}

double radiusOf(const cv::Size& size, double area_ratio) {
  return std::sqrt(static_cast<double>(size.width) * size.height / (area_ratio * kPi));
}

}  // namespace

void AdalamOptions::visit(OptionVisitor& visitor) const {
  visitor.number(
      {"area_ratio", 1, 10000, "-", "Area of an image over the area of the disc that a seed occupies"},
      &AdalamOptions::area_ratio);
  visitor.number(
      {"search_expansion", 1, 20, "-", "Radius of a neighbourhood over the radius of a seed's disc"},
      &AdalamOptions::search_expansion);
  visitor.integer({"samples", 8, 4096, "-", "Affine maps that are tried for each seed; at most 120 differ"},
                  &AdalamOptions::samples);
  visitor.integer({"min_members", 3, 100, "-", "Members beyond those expected by chance that a seed needs"},
                  &AdalamOptions::min_members);
  visitor.number({"confidence", 1, 1e6, "-", "Members of a seed over members expected by chance"},
                 &AdalamOptions::confidence);
  visitor.number(
      {"max_rotation", 0, 180, "deg", "Largest difference of the rotations of seed and member; 180 = off"},
      &AdalamOptions::max_rotation);
  visitor.number({"max_scale_change", 1, 10, "-", "Largest ratio of the scales of seed and member; 10 = off"},
                 &AdalamOptions::max_scale_change);
  visitor.number({"max_stretch", 1, 100, "-", "Largest singular value of a seed's map, and of its inverse"},
                 &AdalamOptions::max_stretch);
  visitor.number({"seed_ratio", 0, 1, "-", "Seeds have at most this ratio of descriptor distances; 1 = any"},
                 &AdalamOptions::seed_ratio);
  visitor.number({"min_error", 0, 10, "px", "Smaller errors count as this"}, &AdalamOptions::min_error);
  visitor.flag("one_to_one", "Count every point once in the support of a map", &AdalamOptions::one_to_one);
  visitor.integer({"seed", 0, 2147483647, "-",
                   "Seed of the order where there are neither descriptor distances nor probabilities"},
                  &AdalamOptions::seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &AdalamOptions::max_seconds);
  visitConfidence(visitor);
}

Presets AdalamSelector::presets() const {
  return {{"original", {{"seed_ratio", "0.8"}, {"one_to_one", "false"}, {"min_error", "0.01"}}},
          {"recall", {{"confidence", "50"}}}};
}

std::string AdalamSelector::missingInput(const Correspondences& matches) const {
  const auto known = [](const cv::Size& size) { return size.width > 0 && size.height > 0; };
  if (matches.empty()) return "";
  if (!known(matches.left_size)) return "adalam needs the size of the left image";
  if (!known(matches.right_size)) return "adalam needs the size of the right image";
  if (options_.seed_ratio >= 1) return "";
  const char* const names[] = {"distance", "second_distance"};
  for (const char* const name : names) {
    const bool first = name == names[0];
    if ((first ? matches.distance : matches.second_distance).empty())
      return std::string("adalam with seed_ratio below 1 needs the column ") + name;
  }
  return "";
}

void AdalamSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n < kMinMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, adalam needs " + std::to_string(kMinMatches);
    return;
  }
  if (endsAtEqualPoints(matches, result)) return;
  const Deadline deadline(options_.max_seconds);
  AdalamMemory& work = workspace.part<AdalamMemory>();
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options_.seed), work.shuffled);
  const bool ordered = work.ordering.byQuality(matches, work.shuffled, work.by_quality);
  if (!ordered) {
    work.by_quality.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) work.by_quality[i] = i;
    result.message = "neither descriptor distances nor probabilities: seeds are drawn at random";
  }
  const bool compares = options_.max_rotation < kAnyRotation || options_.max_scale_change < kAnyScaleChange;
  const bool frames = compares && !matches.left_frame.empty() && !matches.right_frame.empty();
  if (compares && !frames) {
    result.message += std::string(result.message.empty() ? "" : "; ") +
                      "no local affine frames: rotations and scales are not compared";
  }
  const double radius = radiusOf(matches.left_size, options_.area_ratio);
  const Reach reach{
      radius * options_.search_expansion,
      radiusOf(matches.right_size, options_.area_ratio) * options_.search_expansion,
      options_.max_rotation < kAnyRotation ? static_cast<float>(std::cos(options_.max_rotation * kPi / 180))
                                           : -2.0F,
      options_.max_scale_change < kAnyScaleChange ? static_cast<float>(std::log(options_.max_scale_change))
                                                  : std::numeric_limits<float>::infinity()};
  work.left_groups.number(matches.left_x, matches.left_y, 1);
  work.right_groups.number(matches.right_x, matches.right_y, 1);
  work.best_left.assign(work.left_groups.sizes.size(), 0);
  work.best_right.assign(work.right_groups.sizes.size(), 0);
  layOut(matches, radius / std::sqrt(2.0), frames, work);
  findSeeds(matches, radius, options_.seed_ratio, work);
  work.score.assign(n, 0.0F);
  for (const std::uint32_t seed : work.seeds) {
    if (deadline.passed()) {
      result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
      result.message = "stopped after " + std::to_string(result.iterations) +
                       " seeds, max_seconds = " + formatNumber(options_.max_seconds);
      if (result.iterations == 0) return;
      break;
    }
    ++result.iterations;
    verify(seed, reach, options_, static_cast<std::uint64_t>(result.iterations), work);
  }
  result.score = work.score;
  for (std::size_t i = 0; i < n; ++i) result.mask[i] = work.score[i] > 0 ? 1 : 0;
}

}  // namespace corrsel::core
