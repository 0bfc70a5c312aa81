#pragma once

#include <sys/wait.h>

#include <cstdio>
#include <string>

namespace corrsel::testing {

/// What a command printed on both streams, and how it ended (128 + signal where one ended it).
struct Output {
  int code = -1;
  std::string text;
};

/// Runs a shell command and waits for it.
inline Output shell(const std::string& command) {
  Output output;
  FILE* const pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return output;
  char buffer[4096];
  while (std::size_t n = fread(buffer, 1, sizeof(buffer), pipe)) output.text.append(buffer, n);
  const int status = pclose(pipe);
  output.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return output;
}

}  // namespace corrsel::testing
