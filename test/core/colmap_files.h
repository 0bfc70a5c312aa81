#pragma once

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "posed_scene.h"

namespace corrsel::core::testing {

/// Writes sparse models of COLMAP, as text and binary.
class ColmapFiles : public PosedScene {
 protected:
  struct Image {
    int id = 0, camera = 1;
    std::string name;
    RigidMotion pose;  ///< from the world to the camera
    std::vector<std::int64_t> points;
  };
  struct Camera {
    int id = 1;
    std::string model = "PINHOLE";
    int number = 1;  ///< of the model in binary files
    std::vector<double> parameters;
  };

  /// camera(), in COLMAP's pixel coordinates.
  static Camera pinhole() {
    return {1, "PINHOLE", 1, {camera()(0, 0), camera()(1, 1), camera()(0, 2) + 0.5, camera()(1, 2) + 0.5}};
  }

  void writeText(const std::string& folder, const std::vector<Camera>& cameras,
                 const std::vector<Image>& images) const {
    std::string text = "# Camera list with one line of data per camera:\n";
    for (const Camera& camera : cameras) {
      text += std::to_string(camera.id) + " " + camera.model + " 320 240";
      for (const double value : camera.parameters) text += " " + std::to_string(value);
      text += "\n";
    }
    write(folder + "/cameras.txt", text);
    text = "# Image list with two lines of data per image:\n";
    for (const Image& image : images) {
      text += std::to_string(image.id);
      const cv::Vec4d q = quaternion(image.pose.rotation);
      for (int i = 0; i < 4; ++i) text += " " + std::to_string(q[i]);
      for (int i = 0; i < 3; ++i) text += " " + std::to_string(image.pose.translation[i]);
      text += " " + std::to_string(image.camera) + " " + image.name + "\n";
      for (const std::int64_t point : image.points) text += "1.5 2.5 " + std::to_string(point) + " ";
      text += "\n";
    }
    write(folder + "/images.txt", text);
  }

  void writeBinary(const std::string& folder, const std::vector<Camera>& cameras,
                   const std::vector<Image>& images) const {
    std::string bytes;
    add<std::uint64_t>(bytes, cameras.size());
    for (const Camera& camera : cameras) {
      add<std::uint32_t>(bytes, static_cast<std::uint32_t>(camera.id));
      add<std::int32_t>(bytes, camera.number);
      add<std::uint64_t>(bytes, kWidth);
      add<std::uint64_t>(bytes, kHeight);
      for (const double value : camera.parameters) add(bytes, value);
    }
    write(folder + "/cameras.bin", bytes);
    bytes.clear();
    add<std::uint64_t>(bytes, images.size());
    for (const Image& image : images) {
      add<std::uint32_t>(bytes, static_cast<std::uint32_t>(image.id));
      const cv::Vec4d q = quaternion(image.pose.rotation);
      for (int i = 0; i < 4; ++i) add(bytes, q[i]);
      for (int i = 0; i < 3; ++i) add(bytes, image.pose.translation[i]);
      add<std::uint32_t>(bytes, static_cast<std::uint32_t>(image.camera));
      bytes += image.name + '\0';
      add<std::uint64_t>(bytes, image.points.size());
      for (const std::int64_t point : image.points) {
        add(bytes, 1.5);
        add(bytes, 2.5);
        add(bytes, point);
      }
    }
    write(folder + "/images.bin", bytes);
  }

 private:
  template <typename Number>
  static void add(std::string& bytes, Number value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
  }
};

}  // namespace corrsel::core::testing
