#include "daemon/process/crash_note.hpp"

#include <elf.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <memory>
#include <span>
#include <vector>

#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kMaxFrames = 64;
constexpr size_t kMaxKeptNotes = 8;
constexpr size_t kCrashStackBytes = 64 * 1024;
constexpr mode_t kNoteMode = 0640;

/// A loaded file: the program, or a shared library.
struct LoadedFile {
  uintptr_t base = 0, begin = 0, end = 0;
  std::array<char, 64> name{};
  std::array<char, 64> build_id{};  // hexadecimal
};

// A signal handler may not allocate: everything that it uses exists before.
std::array<char, 4096> note_path{};
std::array<LoadedFile, 64> loaded_files{};
size_t loaded_count = 0;
std::array<std::array<char, 4096>, 2> remembered{};  // one is read, the other written
std::array<std::atomic<size_t>, 2> remembered_size{};
std::atomic<size_t> remembered_last{0};

void copy_text(std::string_view text, std::span<char> to) { text.copy(to.data(), to.size() - 1); }

void copy_build_id(const char* notes, size_t size, LoadedFile& file) {
  constexpr const char* kDigits = "0123456789abcdef";
  for (size_t at = 0; at + sizeof(ElfW(Nhdr)) <= size;) {
    ElfW(Nhdr) header;
    std::memcpy(&header, notes + at, sizeof(header));
    const size_t name = at + sizeof(header);
    const size_t id = name + (header.n_namesz + 3) / 4 * 4;
    if (header.n_type == NT_GNU_BUILD_ID && header.n_namesz == 4 && id + header.n_descsz <= size) {
      for (size_t i = 0; i < header.n_descsz && 2 * i + 2 < file.build_id.size(); ++i) {
        const auto byte = static_cast<unsigned char>(notes[id + i]);
        file.build_id[2 * i] = kDigits[byte / 16];
        file.build_id[2 * i + 1] = kDigits[byte % 16];
      }
      return;
    }
    at = id + (header.n_descsz + 3) / 4 * 4;
  }
}

int add_loaded_file(dl_phdr_info* info, size_t /*size*/, void* /*data*/) {
  if (loaded_count == loaded_files.size()) return 1;
  LoadedFile& file = loaded_files[loaded_count++];
  file = {};
  file.base = info->dlpi_addr;
  file.begin = UINTPTR_MAX;
  const std::string_view path = info->dlpi_name;
  copy_text(path.empty() ? program_invocation_short_name : path.substr(path.rfind('/') + 1),
            file.name);
  for (size_t i = 0; i < info->dlpi_phnum; ++i) {
    const auto& segment = info->dlpi_phdr[i];
    const uintptr_t begin = file.base + segment.p_vaddr;
    if (segment.p_type == PT_LOAD) {
      file.begin = std::min(file.begin, begin);
      file.end = std::max(file.end, begin + segment.p_memsz);
    }
    if (segment.p_type == PT_NOTE) {
      // NOLINTNEXTLINE(performance-no-int-to-ptr): the loader states addresses as numbers
      copy_build_id(reinterpret_cast<const char*>(begin), segment.p_memsz, file);
    }
  }
  return 0;
}

// --- async-signal-safe from here ---

void put(int file, const char* text, size_t size) {
  while (size > 0) {
    const ssize_t written = write(file, text, size);
    if (written <= 0) return;
    text += written;
    size -= static_cast<size_t>(written);
  }
}

void put(int file, const char* text) { put(file, text, strlen(text)); }

void put_number(int file, uintptr_t number, unsigned base) {
  std::array<char, 24> digits{};
  size_t at = digits.size();
  do {
    digits[--at] = "0123456789abcdef"[number % base];
    number /= base;
  } while (number > 0);
  put(file, digits.data() + at, digits.size() - at);
}

void put_frame(int file, uintptr_t address) {
  const LoadedFile* of = nullptr;
  for (size_t i = 0; i < loaded_count; ++i) {
    if (address >= loaded_files[i].begin && address < loaded_files[i].end) of = &loaded_files[i];
  }
  put(file, "0x");
  put_number(file, address - (of != nullptr ? of->base : 0), 16);
  if (of != nullptr) {
    put(file, " ");
    put(file, of->name.data());
    put(file, " ");
    put(file, of->build_id.data());
  }
  put(file, "\n");
}

// SA_RESETHAND restored the default action: the second signal ends the process.
void on_crash(int signal) {
  write_crash_note(signal);
  raise(signal);
}

/// Stack for the handlers of one thread. One that is there already stays: a sanitizer's.
class CrashStack {
 public:
  CrashStack() {
    stack_t before{};
    if (sigaltstack(nullptr, &before) != 0 || (before.ss_flags & SS_DISABLE) == 0) return;
    memory_ = std::make_unique<std::array<char, kCrashStackBytes>>();
    stack_t stack{};
    stack.ss_sp = memory_->data();
    stack.ss_size = memory_->size();
    sigaltstack(&stack, nullptr);
  }
  ~CrashStack() {
    if (memory_ == nullptr) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    sigaltstack(&none, nullptr);
  }
  CrashStack(const CrashStack&) = delete;
  CrashStack& operator=(const CrashStack&) = delete;

 private:
  std::unique_ptr<std::array<char, kCrashStackBytes>> memory_;
};

}  // namespace

void use_crash_stack() { static thread_local const CrashStack stack; }

void write_crash_note(int signal) {
  if (note_path[0] == '\0') return;
  const int file =
      open(note_path.data(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, kNoteMode);
  if (file < 0) return;
  put(file, "signal ");
  put_number(file, static_cast<uintptr_t>(signal), 10);
  put(file, "\n\ncalls: address in the file, file, its build id\n");
  std::array<void*, kMaxFrames> frames{};
  const int count = backtrace(frames.data(), static_cast<int>(frames.size()));
  for (int i = 0; i < count; ++i) {
    put_frame(file, reinterpret_cast<uintptr_t>(frames[static_cast<size_t>(i)]));
  }
  put(file, "\nlast reports:\n");
  const size_t last = remembered_last.load();
  put(file, remembered[last].data(), remembered_size[last].load());
  fsync(file);
  close(file);
}

void install_crash_handler(const std::filesystem::path& file) {
  const std::string& path = file.native();
  if (path.size() >= note_path.size()) return;
  loaded_count = 0;
  dl_iterate_phdr(add_loaded_file, nullptr);
  void* frame = nullptr;
  backtrace(&frame, 1);  // loads what it needs, which a handler may not
  note_path.fill('\0');
  copy_text(path, note_path);
  use_crash_stack();
  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_NODEFER | SA_ONSTACK;
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE}) sigaction(signal, &action, nullptr);
}

void remember_report(std::string_view text) {
  const size_t next = 1 - remembered_last.load();
  remembered_size[next] = text.copy(remembered[next].data(), remembered[next].size());
  remembered_last = next;
}

std::optional<std::string> keep_crash_note(const std::filesystem::path& file,
                                           const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code failed;
  const fs::path kept = file.parent_path() / ("crash-" + name + ".txt");
  fs::rename(file, kept, failed);
  if (failed) return std::nullopt;
  fs::permissions(kept, fs::perms::group_read, fs::perm_options::add, failed);  // despite the umask
  std::vector<fs::path> notes;
  for (fs::directory_iterator entry(file.parent_path(), failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string other = entry->path().filename().string();
    if (other.starts_with("crash-") && other.ends_with(".txt")) notes.push_back(entry->path());
  }
  std::sort(notes.begin(), notes.end());  // by time
  for (size_t i = 0; i + kMaxKeptNotes < notes.size(); ++i) fs::remove(notes[i], failed);
  const auto text = text::read_text(kept, 64 << 10);
  const std::string first = text ? text->substr(0, text->find('\n')) : "unreadable";
  return first + ", see " + kept.string();
}

}  // namespace infuse::daemon
