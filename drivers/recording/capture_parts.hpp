#pragma once

#include <filesystem>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Recordings of a folder, in order of their names: files with a capture's name (.pcap, .pcapng or
/// .cap, with the number that tcpdump -C appends, with .gz or .zst); of numbered parts the first.
std::vector<std::filesystem::path> list_captures(const std::filesystem::path& folder);

/// True if a path is a folder of captures that is not a drive.
bool is_capture_folder(const std::filesystem::path& path);

/// Finds the files that make up one recording, in the order of their names:
///
/// - a file: alone, or with its numbered parts if it is the first of them: x.pcap, x.pcap1 …
///   (tcpdump -C), x.pcap00, x.pcap01 … (tcpdump -W), x_00001_20260101120000.pcap … (dumpcap);
/// - a folder: all captures in it;
/// - a pattern with *, ? or […]: the files that match.
///
/// Errors: a folder without captures, a pattern without matches. A path that does not exist is
/// returned as it is.
Result<std::vector<std::filesystem::path>> find_capture_parts(const std::filesystem::path& path);

}  // namespace infuse::recording
