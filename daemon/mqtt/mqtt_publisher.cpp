#include "daemon/mqtt/mqtt_publisher.hpp"

#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "daemon/mqtt/mqtt_client.hpp"
#include "daemon/mqtt/report_topics.hpp"
#include "daemon/process/crash_note.hpp"
#include "daemon/protocol/json.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr size_t kMaxMailbox = 1000;  // number of reports
constexpr size_t kMaxInFlight = 20;   // number of reports that are not acknowledged
constexpr milliseconds kLoop{100};    // longest wait of one step
constexpr milliseconds kConnectTime{30'000};
constexpr milliseconds kFirstRetry{1'000}, kLastRetry{60'000};
constexpr milliseconds kDiskRetry{2'000};  // while the queue's file cannot be used

/// Delay before the next attempt; vehicles that lost the same broker do not return at once.
milliseconds retry_delay(int attempt, const std::string& vehicle) {
  const milliseconds doubled = kFirstRetry * (1 << std::min(attempt, 6));
  const auto spread = static_cast<int64_t>(std::hash<std::string>{}(vehicle) % 500);
  return std::min(doubled, kLastRetry) * (1000 + spread) / 1000;
}

/// The password of `settings`, or an empty text.
Result<std::string> read_password(const MqttSettings& settings) {
  constexpr size_t kMaxPasswordBytes = 4096;
  if (settings.password_file.empty()) return std::string();
  auto text = text::read_text(settings.password_file, kMaxPasswordBytes);
  if (!text) return text;
  return text->substr(0, text->find_first_of("\r\n"));
}

}  // namespace

/// What the two threads share, and the thread's own state. The thread owns it too, so that a name
/// server that does not answer cannot hold up the end.
class MqttPublisher::Worker {
 public:
  Worker(const MqttSettings& settings, std::string password, std::string release,
         const std::filesystem::path& queue_file)
      : settings_(settings),
        password_(std::move(password)),
        release_(std::move(release)),
        queue_(queue_file, settings.queue) {
    if (!queue_.damage().empty()) log_->warn("mqtt: {}", queue_.damage());
    update_stats();
  }

  void add(QueuedReport report) {
    const std::lock_guard lock(mutex_);
    if (mailbox_.size() >= kMaxMailbox) {
      ++overflowed_;
    } else {
      mailbox_.push_back(std::move(report));
    }
    changed_.notify_all();
  }

  QueueStats stats() const {
    return {"mqtt_kib", static_cast<uint32_t>(bytes_ / 1024),
            static_cast<uint32_t>(queue_.max_bytes() / 1024), dropped_ + overflowed_};
  }

  std::string disk_problem() {
    const std::lock_guard lock(mutex_);
    return disk_problem_;
  }

  /// Returns after the thread has done its work, or after `timeout`. Whether it has.
  bool stop(milliseconds timeout) {
    {
      std::unique_lock lock(mutex_);
      deadline_ = Clock::now() + timeout;
      changed_.notify_all();
      if (changed_.wait_for(lock, timeout + kLoop, [&] { return ended_; })) return true;
    }
    const std::unique_lock storing(queue_mutex_, std::try_to_lock);
    if (storing) store_mailbox();  // the thread waits for a host that does not answer
    return false;
  }

  /// The thread.
  void run() {
    // A broker that closes its socket must not end the process (SIGPIPE), and other signals belong
    // to the main thread, but for those of a crash of this one.
    sigset_t all;
    sigfillset(&all);
    for (const int crash : {SIGSEGV, SIGBUS, SIGILL, SIGFPE}) sigdelset(&all, crash);
    pthread_sigmask(SIG_BLOCK, &all, nullptr);
    pthread_setname_np(pthread_self(), "broker");
    use_crash_stack();
    std::unique_lock storing(queue_mutex_);
    while (!is_over()) {
      store_mailbox();
      if (!client_) begin_connection(storing);
      if (!client_) {
        wait_for_change();
        continue;
      }
      publish_waiting();
      if (const auto alive = client_->run(kLoop); !alive) {
        end_connection(alive.error());
      } else if (!client_->connected() && Clock::now() - attempted_ > kConnectTime) {
        end_connection({"no answer", settings_.host, ""});
      }
      announce_connection();
    }
    say_goodbye();
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }

 private:
  /// What the status topic says.
  std::string status(bool online, uint64_t dropped) const {
    Json status = {{"online", online}, {"release", release_}, {"dropped", dropped}};
    if (!settings_.config_digest.empty()) status["config_digest"] = settings_.config_digest;
    if (!settings_.config_version.empty()) status["config_version"] = settings_.config_version;
    return json_text(status);
  }

  std::optional<Clock::time_point> deadline() {
    const std::lock_guard lock(mutex_);
    return deadline_;
  }

  /// Stop was requested, and all is published or cannot be.
  bool is_over() {
    const auto until = deadline();
    if (!until) return false;
    store_mailbox();
    return Clock::now() >= *until || !client_ || !client_->connected() || queue_.messages() == 0;
  }

  void wait_for_change() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, kLoop, [&] { return deadline_.has_value(); });
  }

  void store_mailbox() {
    std::deque<QueuedReport> reports;
    {
      const std::lock_guard lock(mutex_);
      reports.swap(mailbox_);
    }
    for (const QueuedReport& report : reports) {
      if (const auto added = queue_.add(report); !added) {
        log_->warn("mqtt: {}", added.error().message());
      }
    }
    retry_disk();
    update_stats();
  }

  /// Reports that were in memory have other numbers then: those in flight are published again.
  void retry_disk() {
    if (queue_.disk_problem().empty() || Clock::now() < next_disk_attempt_) return;
    next_disk_attempt_ = Clock::now() + kDiskRetry;
    if (!queue_.try_file()) return;
    in_flight_.clear();
    last_sent_ = 0;
  }

  void begin_connection(std::unique_lock<std::mutex>& storing) {
    if (Clock::now() < next_attempt_ || deadline()) return;
    attempted_ = Clock::now();
    client_ = std::make_unique<MqttClient>(
        settings_, password_, MqttClient::Will{status_topic(settings_), status(false, dropped_)},
        [this](int number) { acknowledged(number); });
    storing.unlock();  // names are resolved, which may take long
    const auto begun = client_->connect();
    storing.lock();
    if (!begun) end_connection(begun.error());
  }

  void announce_connection() {
    if (!client_ || !client_->connected() || announced_) return;
    client_->publish(status_topic(settings_), status(true, stats().lost), true);
    log_->info("mqtt: connected to {}, {} reports are queued", settings_.host, queue_.messages());
    announced_ = true;
    attempts_ = 0;
    failure_.clear();
  }

  void end_connection(const Error& why) {
    client_.reset();
    announced_ = false;
    in_flight_.clear();
    last_sent_ = 0;
    next_attempt_ = Clock::now() + retry_delay(attempts_++, settings_.vehicle);
    if (std::string text = why.message(); text != failure_) {
      log_->warn("mqtt: {}; reports are queued", text);
      failure_ = std::move(text);
    }
  }

  void publish_waiting() {
    while (client_->connected() && in_flight_.size() < kMaxInFlight) {
      const auto report = queue_.next_after(last_sent_);
      if (!report) return;
      const auto number = client_->publish(report->topic, report->payload, report->retain);
      if (!number) return;
      in_flight_[*number] = report->id;
      last_sent_ = report->id;
    }
  }

  void acknowledged(int number) {
    const auto sent = in_flight_.find(number);
    if (sent == in_flight_.end()) return;
    queue_.remove(sent->second);
    in_flight_.erase(sent);
    update_stats();
  }

  void say_goodbye() {
    if (!client_ || !client_->connected()) return;
    client_->publish(status_topic(settings_), status(false, stats().lost), true);
    static_cast<void>(client_->run(kLoop));
    client_->disconnect();
    static_cast<void>(client_->run(kLoop));
  }

  void update_stats() {
    bytes_ = queue_.bytes();
    dropped_ = queue_.dropped();
    const std::lock_guard lock(mutex_);
    disk_problem_ = queue_.disk_problem();
  }

  const MqttSettings settings_;
  const std::string password_;
  const std::string release_;
  /// Its own share: a thread that still waits for a host may outlive the process' default logger.
  const std::shared_ptr<spdlog::logger> log_ = spdlog::default_logger();

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<QueuedReport> mailbox_;
  std::string disk_problem_;
  std::optional<Clock::time_point> deadline_;  // of the end
  bool ended_ = false;
  std::atomic<uint64_t> bytes_ = 0, dropped_ = 0, overflowed_ = 0;

  std::mutex queue_mutex_;  // held by the thread, but while it connects
  ReportQueue queue_;
  std::unique_ptr<MqttClient> client_;
  std::map<int, int64_t> in_flight_;  // identifier in the queue, by the client's number
  int64_t last_sent_ = 0;
  int attempts_ = 0;
  Clock::time_point attempted_, next_attempt_, next_disk_attempt_;
  bool announced_ = false;
  std::string failure_;  // logged last
};

Result<std::unique_ptr<MqttPublisher>> MqttPublisher::start(const MqttSettings& settings,
                                                            const std::filesystem::path& queue_file,
                                                            std::string release) {
  auto password = read_password(settings);
  if (!password) return tl::unexpected(password.error());
  auto worker =
      std::make_shared<Worker>(settings, *std::move(password), std::move(release), queue_file);
  std::thread thread([worker] { worker->run(); });
  return std::unique_ptr<MqttPublisher>(new MqttPublisher(worker, std::move(thread)));
}

MqttPublisher::~MqttPublisher() { finish(milliseconds{0}); }

void MqttPublisher::add(QueuedReport report) { worker_->add(std::move(report)); }

QueueStats MqttPublisher::stats() const { return worker_->stats(); }

std::string MqttPublisher::disk_problem() const { return worker_->disk_problem(); }

void MqttPublisher::finish(milliseconds timeout) {
  if (!thread_.joinable()) return;
  if (worker_->stop(timeout)) {
    thread_.join();
  } else {
    thread_.detach();  // it waits for a host that does not answer
  }
}

}  // namespace infuse::daemon
