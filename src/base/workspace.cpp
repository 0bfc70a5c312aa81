#include "corrsel/workspace.h"

namespace corrsel::core {

Workspace::Workspace() = default;
Workspace::~Workspace() = default;
Workspace::Workspace(Workspace&&) noexcept = default;
Workspace& Workspace::operator=(Workspace&&) noexcept = default;

void Workspace::release() {
  parts_.clear();
  parts_.shrink_to_fit();
}

Workspace& Workspace::ofThread() {
  thread_local Workspace workspace;
  return workspace;
}

std::shared_ptr<void>& Workspace::find(const void* key) {
  for (auto& [part_key, part] : parts_) {
    if (part_key == key) return part;
  }
  return parts_.emplace_back(key, nullptr).second;
}

}  // namespace corrsel::core
