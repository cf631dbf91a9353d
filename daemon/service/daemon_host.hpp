#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <functional>

#include "daemon/calibration/calibration_ledger.hpp"
#include "daemon/command_line/exit_code.hpp"
#include "daemon/config/config.hpp"
#include "daemon/mapping/map_folder.hpp"
#include "daemon/pipeline/pipeline.hpp"
#include "daemon/server/server.hpp"
#include "daemon/streetmap/street_map_file.hpp"

namespace infuse::daemon {

/// Why the daemon cannot start, and its exit code.
struct StartError {
  Error error;
  ExitCode code = kUsage;
};

/// A map of keyframes that was opened.
struct OpenedPlaces {
  places::PlaceMap map;
  std::string digest;
  MapFolder::Id folder;  ///< that its clouds are read from
};

/// Opens the configured street map; an empty map if none is configured. Fails if the file is
/// missing or damaged, or has no latitude and longitude though the initial pose is given by them.
Result<StreetMapFile> open_street_map(const Config& config);

/// Opens the configured map of keyframes; nothing if none is configured. Fails if it is not
/// complete or a file is damaged.
Result<std::optional<OpenedPlaces>> open_place_map(const Config& config);

/// Everything around the pipeline that a live run and a replay share: the event loop, the server,
/// the saved calibrations, the street map, control requests and signals. The composition root of
/// `infused`: open(), build the pipeline from pipeline_options(), connect(), run().
///
/// Single-threaded: all calls are made on the thread that calls run().
class DaemonHost {
 public:
  /// Executes a recording request; an error says why it is rejected.
  using RequestHandler = std::function<Result<void>(const Request&)>;
  /// Hands a command to the calibration of a camera.
  using CommandHandler = std::function<void(const CalibrationCommand&)>;

  /// `config` must outlive this object. Calibrations in use are kept in `state_folder`; an empty
  /// path disables that.
  DaemonHost(const Config& config, const std::filesystem::path& state_folder);

  /// Puts the saved calibrations into `rig`, opens the street map and starts to listen at `socket`
  /// (see `listen_for_clients`). Errors: the street map cannot be read (kUnreadable), the socket
  /// cannot be opened (kUsage).
  tl::expected<void, StartError> open(Rig& rig, const std::string& socket);

  /// Options for the pipeline, from the configuration and the opened maps, which they take: to be
  /// called once.
  PipelineOptions pipeline_options();

  /// Connects the pipeline: numbers and saves its calibrations, restores frozen ones, and decides
  /// control requests. `on_record` handles recording requests; without it they are rejected.
  void connect(Pipeline& pipeline, RequestHandler on_record = nullptr);

  /// The same with the parts that it uses of a pipeline: its publisher, and who handles commands.
  void connect(Publisher& publisher, CommandHandler on_command, RequestHandler on_record = nullptr);

  /// Executes a control request, as if its owner had sent it. What it decides is saved before this
  /// returns. Returns a note for the owner, which may be empty.
  Result<std::string> handle_request(const Request& request);

  /// Runs the event loop until finish() has been called and all clients are gone. `on_stop` is
  /// called at the first SIGINT or SIGTERM; a second one ends the process.
  void run(std::function<void()> on_stop);

  /// Lets the event loop end: closes the server after at most `client_timeout`, in which clients
  /// read what is queued for them. Called when the pipeline has ended.
  void finish(std::chrono::milliseconds client_timeout);

  /// Why calibrations could not be saved last; empty if they could.
  const std::string& calibrations_problem() const { return calibrations_problem_; }

  /// Why the saved calibrations could not be read; nothing if they could.
  const std::optional<std::string>& calibration_damage() const { return calibrations_.damage(); }

  /// Digest of the street map, and of the map of keyframes, at the start; empty without it.
  const std::string& street_map_digest() const { return street_map_digest_; }
  const std::string& places_digest() const { return places_digest_; }

  /// Folder of the map of keyframes that was opened.
  MapFolder::Id places_folder() const { return places_folder_; }

  boost::asio::io_context& io() { return io_; }
  Server& server() { return server_; }

 private:
  void complete(CalibrationReport& report);

  const Config& config_;
  boost::asio::io_context io_{1};
  boost::asio::signal_set stop_signals_{io_, SIGINT, SIGTERM};
  Server server_;
  CalibrationLedger calibrations_;
  std::string calibrations_problem_;
  CommandHandler on_command_;
  RequestHandler on_record_;
  Maps maps_;
  std::string street_map_digest_, places_digest_;
  MapFolder::Id places_folder_;
};

/// Opens the sockets for clients: the service manager's, or else `socket`, the configured path, or
/// the default path, which is optional: the daemon runs without it if it cannot be created. In
/// addition TCP on the loopback if it is configured.
Result<void> listen_for_clients(Server& server, const std::string& socket,
                                const ServerOptions& options);

}  // namespace infuse::daemon
