#pragma once

#include <memory>

#include "corrsel/workspace.h"

namespace corrsel::core {

/// Makes the calling thread use a workspace for as long as the object lives.
class WorkspaceScope {
 public:
  explicit WorkspaceScope(Workspace& workspace);
  ~WorkspaceScope();
  WorkspaceScope(const WorkspaceScope&) = delete;
  WorkspaceScope& operator=(const WorkspaceScope&) = delete;

  /// The workspace that the calling thread uses: that of the innermost scope, else the thread's own.
  static Workspace& current();

  /// The part of type T in the current workspace; made by its default constructor where there is none yet.
  template <class T>
  static T& part() {
    return current().part<T>();
  }

 private:
  Workspace* before_;
};

}  // namespace corrsel::core
