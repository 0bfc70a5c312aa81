#pragma once

#include <memory>
#include <utility>
#include <vector>

namespace corrsel::core {

/// Memory that selectors keep from one call to the next, so that a call with an input of the same size
/// allocates next to nothing.
///
/// Every thread has a workspace of its own, which select() uses unless it is given another one, and which
/// lives as long as the thread. A workspace grows to what the largest input so far needed: some ten to a few
/// hundred bytes per match, and for `st` and `gtm` the N^2 bytes of the pairs up to 256 MiB; what exceeds
/// that is freed at the end of the call.
///
/// A program that must bound its memory has two ways. It passes a workspace of its own to
/// Selector::select(), which then leaves that of the thread alone, and releases or destroys it; or it calls
/// Workspace::ofThread().release() on the thread that has selected.
///
/// One workspace serves all selectors, one call at a time. Results do not depend on it. Threads that the
/// option `threads` has started are no part of it; they wait for the next call and end with the thread that
/// called.
class Workspace {
 public:
  Workspace();
  ~Workspace();
  Workspace(Workspace&&) noexcept;
  Workspace& operator=(Workspace&&) noexcept;

  /// Frees the memory; the next call allocates it again. @pre no select() is using the workspace
  void release();

  /// The workspace of the calling thread.
  static Workspace& ofThread();

  /// The part of type T, made by its default constructor where there is none yet. The reference stays valid
  /// until release().
  template <class T>
  T& part() {
    static char key;  // its address identifies T
    std::shared_ptr<void>& part = find(&key);
    if (!part) part = std::make_shared<T>();
    return *static_cast<T*>(part.get());
  }

 private:
  std::shared_ptr<void>& find(const void* key);

  std::vector<std::pair<const void*, std::shared_ptr<void>>> parts_;
};

}  // namespace corrsel::core
