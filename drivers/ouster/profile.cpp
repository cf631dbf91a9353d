#include "drivers/ouster/profile.hpp"

#include <algorithm>

namespace infuse::ouster {

const ProfileInfo* find_profile(std::string_view name) {
  const auto found = std::ranges::find(kProfiles, name, &ProfileInfo::name);
  return found == kProfiles.end() ? nullptr : &*found;
}

std::string profile_names() {
  std::string names;
  for (const ProfileInfo& info : kProfiles) {
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  return names;
}

}  // namespace infuse::ouster
