#include <cstdio>
#include <fstream>

#include "base/temporary_folder.h"
#include "corrsel/database/hloc_store.h"
#include "test_support.h"

using namespace corrsel::core;
using namespace corrsel::core::testing;

namespace {

namespace fs = std::filesystem;

constexpr const char* kConfiguration = "auto, threshold 3";

// Three images; keypoint k of image n is at (10 n + k, k / 2). The features are those of hloc (float16), but
// for one image.
constexpr const char* kFeatures = R"(
with h5py.File(folder + "/features.h5", "w") as file:
    for number, (name, kind) in enumerate((("db/a.jpg", "f2"), ("db/b.jpg", "f4"), ("query/c_1.jpg", "f2"))):
        points = np.array([[10 * number + k, k / 2] for k in range(5)], kind)
        file.create_dataset(name + "/keypoints", data=points)
        file.create_dataset(name + "/image_size", data=np.array([640, 480]))
        file.create_dataset(name + "/descriptors", data=np.zeros((8, 5), "f2"))
)";

// The pair (a, b), the pair (c, a) in this order, and (b, c) as older versions write it.
constexpr const char* kMatches = R"(
with h5py.File(folder + "/matches.h5", "w") as file:
    def write(group, rows, scores, kind="i2"):
        file.create_dataset(group + "/matches0", data=np.array(rows, kind))
        if scores is not None:
            file.create_dataset(group + "/matching_scores0", data=np.array(scores, "f2"))
    write("db-a.jpg/db-b.jpg", [1, -1, 0, 3, -1], [0.5, 0, 0.75, 0.25, 0])
    write("query-c_1.jpg/db-a.jpg", [4, 3, -1, -1, 0], [0, 0, 0, 0, 0], "i4")
    write("db-b.jpg_query-c_1.jpg", [-1, -1, 2, -1, 1], None)
)";

/// A folder that is removed at the end, with both files, written by h5py.
class HlocStoreTest : public ::testing::Test {
 protected:
  HlocStoreTest() {
    features = folder / "features.h5";
    matches = folder / "matches.h5";
    output = folder / "verified.h5";
  }

  void SetUp() override {
    static const bool has_h5py = std::system("python3 -c 'import h5py' 2>/dev/null") == 0;
    if (!has_h5py) {
      GTEST_SKIP() << "python3 has no h5py (Debian: python3-h5py)";
    }
    python(kFeatures);
    python(kMatches);
  }

  /// What a program in Python prints that knows h5py, numpy and the folder.
  std::string python(const std::string& program) const {
    const fs::path script = folder / "program.py";
    std::ofstream(script) << "import h5py\nimport numpy as np\nfolder = '" << folder.string() << "'\n"
                          << program;
    std::FILE* const pipe = popen(("python3 " + script.string()).c_str(), "r");
    std::string text;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += char(c);
    EXPECT_EQ(pclose(pipe), 0);
    return text;
  }

  /// Changes the file of the features or of the matches.
  void change(const std::string& file, const std::string& statements) const {
    python("file = h5py.File(folder + '/" + file + ".h5', 'r+')\n" + statements);
  }

  std::string openError() const {
    return errorOf<StoreError>([&] { HlocStore(features, matches, output); });
  }

  std::string matchError(const ImagePairKey& pair) const {
    return errorOf<StoreError>([&] { HlocStore(features, matches).matches(pair); });
  }

  const TemporaryFolder temporary{"corrsel_hloc"};
  const fs::path folder = temporary.path();
  fs::path features, matches, output;
  const ImagePairKey ab{1, 2}, ac{1, 3}, bc{2, 3};
};

VerifiedPair accepted(const ImagePairKey& key, std::vector<KeypointPair> inliers) {
  VerifiedPair pair;
  pair.pair = key;
  pair.putative = 3;
  pair.scene = SceneKind::kRigid;
  pair.confidence = 12.5;
  pair.ambiguity = std::numeric_limits<double>::quiet_NaN();
  pair.geometry.config = TwoViewConfig::kUncalibrated;
  pair.geometry.inliers = std::move(inliers);
  pair.geometry.fundamental = cv::Matx33d(1, 2, 3, 4, 5, 6, 7, 8, 9);
  pair.geometry.pose = Pose{cv::Matx33d::eye(), {0, 0.6, 0.8}};
  return pair;
}

VerifiedPair rejected(const ImagePairKey& key) {
  VerifiedPair pair;
  pair.pair = key;
  pair.status = Status::kNoModel;
  pair.scene = SceneKind::kNothing;
  return pair;
}

TEST_F(HlocStoreTest, ReadsImagesInTheOrderOfTheirNames) {
  const HlocStore store(features, matches);
  ASSERT_EQ(store.images().size(), 3U);
  EXPECT_EQ(store.images()[0].name, "db/a.jpg");
  EXPECT_EQ(store.images()[2].name, "query/c_1.jpg");
  EXPECT_EQ(store.images()[2].id, 3U);
  EXPECT_EQ(store.images()[0].size, cv::Size(640, 480));
  EXPECT_FALSE(store.images()[0].camera);
  EXPECT_TRUE(store.warnings().empty());
}

TEST_F(HlocStoreTest, ReadsKeypointsOfBothPrecisions) {
  const HlocStore store(features, matches);
  for (const std::uint32_t image : {1U, 2U, 3U}) {
    const StoredKeypoints keypoints = store.keypoints(image);
    ASSERT_EQ(keypoints.positions.size(), 5U);
    EXPECT_TRUE(keypoints.frames.empty());
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_EQ(keypoints.positions[k], cv::Point2f(10 * float(image - 1) + float(k), float(k) / 2));
    }
  }
}

TEST_F(HlocStoreTest, ReadsPairsInBothDirectionsAndBothLayouts) {
  const HlocStore store(features, matches);
  EXPECT_EQ(store.pairs(), (std::vector<ImagePairKey>{ab, ac, bc}));
  EXPECT_EQ(store.matches(ab).rows, (std::vector<KeypointPair>{{0, 1}, {2, 0}, {3, 3}}));
  EXPECT_EQ(store.matches(ab).probability, (std::vector<float>{0.5, 0.75, 0.25}));
  EXPECT_EQ(store.matches(ac).rows, (std::vector<KeypointPair>{{4, 0}, {3, 1}, {0, 4}}));
  EXPECT_TRUE(store.matches(ac).probability.empty());  // all are 0
  EXPECT_EQ(store.matches(bc).rows, (std::vector<KeypointPair>{{2, 2}, {4, 1}}));
  EXPECT_TRUE(store.matches(bc).probability.empty());
}

TEST_F(HlocStoreTest, ScoresBeyondOneAreNoProbabilities) {
  change("matches", "file['db-a.jpg/db-b.jpg/matching_scores0'][0] = 7");
  EXPECT_TRUE(HlocStore(features, matches).matches(ab).probability.empty());
}

TEST_F(HlocStoreTest, H5pyReadsTheOutput) {
  HlocStore store(features, matches, output);
  store.write({accepted(ab, {{0, 1}, {3, 3}}), accepted(ac, {{0, 4}, {4, 0}})}, kConfiguration);
  store.write({rejected(bc)}, kConfiguration);
  EXPECT_FALSE(fs::exists(output));
  store.complete(kConfiguration);
  EXPECT_EQ(python(R"(
with h5py.File(folder + "/verified.h5", "r") as file:
    print(file.attrs["corrsel_configuration"])
    for group in ("db-a.jpg/db-b.jpg", "query-c_1.jpg/db-a.jpg", "db-b.jpg_query-c_1.jpg"):
        item = file[group]
        print(item["matches0"].dtype, item["matches0"][()].tolist())
        if "matching_scores0" in item:
            print(item["matching_scores0"].dtype, item["matching_scores0"][()].tolist())
        for name in ("status", "scene", "config", "confidence"):
            print(item.attrs["corrsel_" + name])
)"),
            "auto, threshold 3\n"
            "int16 [1, -1, -1, 3, -1]\nfloat16 [0.5, 0.0, 0.0, 0.25, 0.0]\nok\nrigid\nuncalibrated\n12.5\n"
            "int32 [4, -1, -1, -1, 0]\nfloat16 [0.0, 0.0, 0.0, 0.0, 0.0]\nok\nrigid\nuncalibrated\n12.5\n"
            "int16 [-1, -1, -1, -1, -1]\nno_model\nnothing\nundefined\n0.0\n");
  // Nothing else is left, and the output is a file of matches again.
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 4);
  EXPECT_EQ(HlocStore(features, output).matches(ac).rows, (std::vector<KeypointPair>{{4, 0}, {0, 4}}));
}

TEST_F(HlocStoreTest, PairsWithoutAResultKeepNoMatch) {
  HlocStore store(features, matches, output);
  VerifiedPair faulty = accepted(ac, {{0, 4}});
  faulty.faulty = true;
  store.write({accepted(ab, {{0, 1}}), faulty}, kConfiguration);
  store.complete(kConfiguration);
  EXPECT_EQ(HlocStore(features, output).matches(ab).rows.size(), 1U);
  EXPECT_TRUE(HlocStore(features, output).matches(ac).rows.empty());
  EXPECT_EQ(python("item = h5py.File(folder + '/verified.h5', 'r')['query-c_1.jpg/db-a.jpg']\n"
                   "print(item.attrs['corrsel_status'], len(item.attrs))"),
            "not_verified 1\n");
}

TEST_F(HlocStoreTest, ARunThatWasKilledContinues) {
  const VerifiedPair pair = accepted(ab, {{0, 1}, {3, 3}});
  {
    HlocStore store(features, matches, output);
    store.write({pair, rejected(ac)}, kConfiguration);
  }
  HlocStore store(features, matches, output);
  EXPECT_EQ(store.verifiedPairs(kConfiguration), (std::vector<ImagePairKey>{ab, ac}));
  EXPECT_TRUE(store.verifiedPairs("other").empty());
  const VerifiedPair read = store.verified(ab);
  EXPECT_EQ(read.geometry.config, pair.geometry.config);
  EXPECT_EQ(read.geometry.inliers, pair.geometry.inliers);
  EXPECT_EQ(*read.geometry.fundamental, *pair.geometry.fundamental);
  EXPECT_FALSE(read.geometry.homography);
  EXPECT_FALSE(read.geometry.essential);
  EXPECT_EQ(read.geometry.pose->rotation, pair.geometry.pose->rotation);
  EXPECT_EQ(read.geometry.pose->translation, pair.geometry.pose->translation);
  EXPECT_EQ(read.putative, 3U);
  EXPECT_EQ(read.scene, SceneKind::kRigid);
  EXPECT_EQ(read.confidence, 12.5);
  EXPECT_TRUE(std::isnan(read.ambiguity));
  EXPECT_EQ(store.verified(ac).status, Status::kNoModel);
  store.complete(kConfiguration);
  EXPECT_EQ(HlocStore(features, output).matches(ab).rows, pair.geometry.inliers);
}

TEST_F(HlocStoreTest, ResultsOfOtherFilesAreNotContinued) {
  HlocStore(features, matches, output).write({rejected(ab)}, kConfiguration);
  change("matches", "file.create_dataset('db-c.jpg/keypoints', data=np.zeros((9, 2)))");
  EXPECT_TRUE(mentions(openError(), {"verified.h5.part", "changed", "delete it"}));
}

TEST_F(HlocStoreTest, APairThatStandsThereTwiceIsWrittenTwice) {
  change("matches",
         "file.copy('db-a.jpg/db-b.jpg', 'db-a.jpg_db-b.jpg')\n"
         "file.create_dataset('db-b.jpg/db-a.jpg/matches0', data=np.array([2, 0, 1, 3, -1], 'i2'))");
  HlocStore store(features, matches, output);
  EXPECT_EQ(store.pairs().size(), 3U);
  ASSERT_EQ(store.warnings().size(), 1U);
  EXPECT_TRUE(mentions(store.warnings()[0], {"matches.h5", "2 pairs twice"}));
  store.write({accepted(ab, {{0, 1}, {3, 3}})}, kConfiguration);
  store.complete(kConfiguration);
  EXPECT_EQ(python("file = h5py.File(folder + '/verified.h5', 'r')\n"
                   "for group in ('db-a.jpg/db-b.jpg', 'db-b.jpg/db-a.jpg', 'db-a.jpg_db-b.jpg'):\n"
                   "    print(file[group]['matches0'][()].tolist())"),
            "[1, -1, -1, 3, -1]\n[-1, 0, -1, 3, -1]\n[1, -1, -1, 3, -1]\n");
}

TEST_F(HlocStoreTest, AnImageWithItselfIsSkipped) {
  change("matches", "file.copy('db-a.jpg/db-b.jpg', 'db-a.jpg/db-a.jpg')");
  const HlocStore store(features, matches);
  EXPECT_EQ(store.pairs().size(), 3U);
  ASSERT_EQ(store.warnings().size(), 1U);
  EXPECT_TRUE(mentions(store.warnings()[0], {"db-a.jpg/db-a.jpg", "itself"}));
}

TEST_F(HlocStoreTest, ImagesWithoutKeypointsAndWithoutSizes) {
  change("features",
         "del file['db/b.jpg']\n"
         "file.create_dataset('db/b.jpg/keypoints', data=np.zeros((0, 2), 'f2'))");
  change("matches",
         "for name in ('db-a.jpg/db-b.jpg', 'db-b.jpg_query-c_1.jpg'): del file[name]\n"
         "file['db-b.jpg/db-a.jpg/matches0'] = np.zeros(0, 'i2')");
  HlocStore store(features, matches, output);
  EXPECT_EQ(store.images()[1].size, cv::Size());
  EXPECT_TRUE(store.keypoints(2).positions.empty());
  EXPECT_TRUE(store.matches(ab).rows.empty());
  store.write({rejected(ab)}, kConfiguration);
  store.complete(kConfiguration);
  EXPECT_TRUE(fs::exists(output));
}

TEST_F(HlocStoreTest, NumbersThatWrappedAroundAreRefused) {
  change("matches", "file['db-a.jpg/db-b.jpg/matches0'][1] = -32768");
  EXPECT_TRUE(
      mentions(matchError(ab), {"matches.h5", "db-a.jpg/db-b.jpg/matches0", "row 1", "-32768", "32768"}));
  change("features",
         "del file['db/b.jpg/keypoints']\n"
         "file['db/b.jpg/keypoints'] = np.zeros((32769, 2), 'f2')");
  change("matches", "file['db-a.jpg/db-b.jpg/matches0'][1] = 7");
  EXPECT_TRUE(mentions(matchError(ab), {"16 bits", "32769", "32768"}));
}

TEST_F(HlocStoreTest, WrongContentIsNamed) {
  change("matches",
         "del file['db-a.jpg/db-b.jpg/matching_scores0']\n"
         "file['db-a.jpg/db-b.jpg/matching_scores0'] = np.zeros(4)\n"
         "del file['query-c_1.jpg/db-a.jpg/matches0']\n"
         "file['query-c_1.jpg/db-a.jpg/matches0'] = np.zeros(5)\n"
         "del file['db-b.jpg_query-c_1.jpg/matches0']\n"
         "file['db-b.jpg_query-c_1.jpg/matches0'] = np.zeros(6, 'i2')");
  EXPECT_TRUE(mentions(matchError(ab), {"matching_scores0", "4 numbers", "5"}));
  EXPECT_TRUE(mentions(matchError(ac), {"query-c_1.jpg/db-a.jpg/matches0", "whole numbers"}));
  EXPECT_TRUE(mentions(matchError(bc), {"db-b.jpg_query-c_1.jpg/matches0", "6 numbers", "5 keypoints"}));
  EXPECT_TRUE(mentions(errorOf<StoreError>([&] {
                         HlocStore(features, matches).matches({1, 9});
                       }),
                       {"features.h5", "image 9", "1 to 3"}));
  change("features",
         "del file['db/a.jpg/keypoints']\n"
         "file['db/a.jpg/keypoints'] = np.zeros((5, 3))");
  EXPECT_TRUE(mentions(errorOf<StoreError>([&] { HlocStore(features, matches).keypoints(1); }),
                       {"features.h5", "db/a.jpg/keypoints", "5 x 3", "N x 2"}));
}

TEST_F(HlocStoreTest, WrongSizesAreNamed) {
  change("features", "file['db/a.jpg/image_size'][1] = -2");
  EXPECT_TRUE(mentions(openError(), {"features.h5", "db/a.jpg/image_size", "640, -2"}));
}

TEST_F(HlocStoreTest, FilesThatDoNotBelongTogetherAreNamed) {
  EXPECT_TRUE(
      mentions(errorOf<StoreError>([&] { HlocStore(matches, features); }), {"matches.h5", "keypoints"}));
  change("matches", "file.copy('db-a.jpg/db-b.jpg', 'db-a.jpg/x.jpg')");
  EXPECT_TRUE(mentions(openError(), {"matches.h5", "db-a.jpg/x.jpg", "'x.jpg'", "features.h5"}));
}

TEST_F(HlocStoreTest, NamesThatAreAmbiguousAreRefused) {
  change("features", "file['db-a.jpg/keypoints'] = np.zeros((5, 2))");
  EXPECT_TRUE(mentions(openError(), {"'db-a.jpg'", "db/a.jpg", "rename"}));
}

TEST_F(HlocStoreTest, FilesThatCannotBeUsedAreNamed) {
  std::ofstream(folder / "text.h5") << "no HDF5";
  const auto errorFor = [&](const char* name) {
    return errorOf<StoreError>([&] { HlocStore(features, folder / name); });
  };
  EXPECT_TRUE(mentions(errorFor("missing.h5"), {"missing.h5", "does not exist"}));
  EXPECT_TRUE(mentions(errorFor("text.h5"), {"text.h5", "no HDF5 file"}));
  std::ofstream(output) << "something";
  EXPECT_TRUE(mentions(openError(), {"verified.h5", "exists"}));
  python("h5py.File(folder + '/empty.h5', 'w').close()");
  EXPECT_TRUE(mentions(errorFor("empty.h5"), {"empty.h5", "matches0"}));
}

TEST_F(HlocStoreTest, ADamagedFileIsNamed) {
  fs::resize_file(matches, fs::file_size(matches) - 2000);
  EXPECT_TRUE(mentions(openError(), {"matches.h5"}));
}

TEST_F(HlocStoreTest, WithoutAnOutputNothingIsWritten) {
  HlocStore store(features, matches);
  EXPECT_TRUE(mentions(errorOf<StoreError>([&] { store.write({rejected(ab)}, kConfiguration); }),
                       {"matches.h5", "only read", "output"}));
  EXPECT_TRUE(store.verifiedPairs(kConfiguration).empty());
}

}  // namespace
