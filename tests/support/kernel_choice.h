// Choosing the kernels of a test, and giving the processor's own choice back afterwards.
#pragma once

#include <string>
#include <vector>

#include "engine/kernels.h"

namespace feder {

class KernelChoice {
 public:
  explicit KernelChoice(const std::string& name)
      : before_(kernels().name), available_(select_kernels(name.c_str())) {}
  ~KernelChoice() { (void)select_kernels(before_.c_str()); }
  KernelChoice(const KernelChoice&) = delete;
  KernelChoice& operator=(const KernelChoice&) = delete;

  /// False if this processor does not have them; then nothing was changed.
  bool available() const { return available_; }

 private:
  std::string before_;
  bool available_;
};

inline const std::vector<std::string>& kernel_names() {
  static const std::vector<std::string> names{"scalar", "avx2", "avx512"};
  return names;
}

}  // namespace feder
