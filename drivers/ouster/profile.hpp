#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace infuse::ouster {

/// Layout of a lidar packet's pixels and headers, as the metadata's `udp_profile_lidar` names it.
enum class Profile : uint8_t {
  kLegacy,         ///< LEGACY
  kRng19,          ///< RNG19_RFL8_SIG16_NIR16
  kRng19Dual,      ///< RNG19_RFL8_SIG16_NIR16_DUAL
  kRng15,          ///< RNG15_RFL8_NIR8
  kFusaDual,       ///< FUSA_RNG15_RFL8_NIR8_DUAL
  kRng15Dual,      ///< RNG15_RFL8_NIR8_DUAL
  kRng15Zone,      ///< RNG15_RFL8_NIR8_ZONE16
  kRng15Window,    ///< RNG15_RFL8_WIN8
  kRng19Zone,      ///< RNG19_RFL8_SIG16_NIR16_ZONE16
  kRng19ZoneDual,  ///< RNG19_RFL8_SIG16_ZONE16_DUAL
};

/// A quantity of a pixel: `bits` bits of the little-endian word that begins at `offset`, times
/// `unit`. No bits: the profile has none.
struct PixelField {
  uint8_t offset = 0;  ///< bytes from the pixel's beginning
  uint8_t bits = 0;
  uint8_t unit = 1;

  /// The quantity of the pixel that begins at `pixel`.
  constexpr uint32_t read(const uint8_t* pixel) const {
    uint32_t word = 0;
    for (uint32_t i = 0; i * 8 < bits; ++i) {
      word |= static_cast<uint32_t>(pixel[offset + i]) << (8 * i);
    }
    return (word & ((uint32_t{1} << bits) - 1)) * unit;
  }
};

/// What a profile states of one return of a pixel.
struct EchoFields {
  PixelField range;         ///< mm; 0: no return
  PixelField reflectivity;  ///< 0 … 255; wider in LEGACY before firmware 2.1
  PixelField signal;        ///< photons
};

/// Properties of a profile. Sources: Ouster's manual "Sensor Data", lidar data format; of the
/// profiles with zones and windows, and of RNG15 with two returns, what its SDK states.
struct ProfileInfo {
  Profile profile;
  std::string_view name;  ///< as the metadata has it
  uint8_t pixel_bytes;
  uint8_t echoes;  ///< number of returns of a pixel, 1 or 2
  std::array<EchoFields, 2> echo;
  PixelField near_infrared;  ///< photons, also where there is no return

  /// Bytes before the first column and after the last.
  constexpr size_t packet_header_bytes() const { return profile == Profile::kLegacy ? 0 : 32; }
  /// Bytes of a column before its pixels.
  constexpr size_t column_header_bytes() const { return profile == Profile::kLegacy ? 16 : 12; }
  /// Bytes of a column after its pixels.
  constexpr size_t column_footer_bytes() const { return profile == Profile::kLegacy ? 4 : 0; }
};

/// All profiles, by `Profile`.
inline constexpr std::array<ProfileInfo, 10> kProfiles{{
    {Profile::kLegacy, "LEGACY", 12, 1, {{{{0, 20}, {4, 16}, {6, 16}}, {}}}, {8, 16}},
    {Profile::kRng19, "RNG19_RFL8_SIG16_NIR16", 12, 1, {{{{0, 19}, {4, 8}, {6, 16}}, {}}}, {8, 16}},
    {Profile::kRng19Dual,
     "RNG19_RFL8_SIG16_NIR16_DUAL",
     16,
     2,
     {{{{0, 19}, {3, 8}, {8, 16}}, {{4, 19}, {7, 8}, {10, 16}}}},
     {12, 16}},
    {Profile::kRng15, "RNG15_RFL8_NIR8", 4, 1, {{{{0, 15, 8}, {2, 8}, {}}, {}}}, {3, 8, 16}},
    {Profile::kFusaDual,
     "FUSA_RNG15_RFL8_NIR8_DUAL",
     8,
     2,
     {{{{0, 15, 8}, {2, 8}, {}}, {{4, 15, 8}, {6, 8}, {}}}},
     {3, 8, 16}},
    {Profile::kRng15Dual,
     "RNG15_RFL8_NIR8_DUAL",
     8,
     2,
     {{{{0, 15, 8}, {2, 8}, {}}, {{4, 15, 8}, {6, 8}, {}}}},
     {3, 8, 16}},
    {Profile::kRng15Zone,
     "RNG15_RFL8_NIR8_ZONE16",
     8,
     1,
     {{{{0, 15, 8}, {2, 8}, {}}, {}}},
     {3, 8, 16}},
    {Profile::kRng15Window, "RNG15_RFL8_WIN8", 4, 1, {{{{0, 15, 8}, {2, 8}, {}}, {}}}, {}},
    {Profile::kRng19Zone,
     "RNG19_RFL8_SIG16_NIR16_ZONE16",
     12,
     1,
     {{{{0, 19}, {4, 8}, {6, 16}}, {}}},
     {8, 16}},
    {Profile::kRng19ZoneDual,
     "RNG19_RFL8_SIG16_ZONE16_DUAL",
     16,
     2,
     {{{{0, 19}, {3, 8}, {8, 16}}, {{4, 19}, {7, 8}, {10, 16}}}},
     {}},
}};

/// Properties of a profile.
constexpr const ProfileInfo& profile_info(Profile profile) {
  return kProfiles[static_cast<size_t>(profile)];
}

/// The profile of this name, or null.
const ProfileInfo* find_profile(std::string_view name);

/// Names of all profiles, separated by commas.
std::string profile_names();

}  // namespace infuse::ouster
