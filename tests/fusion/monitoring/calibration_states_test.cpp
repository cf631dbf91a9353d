#include "fusion/monitoring/calibration_states.hpp"

#include <gtest/gtest.h>

#include <array>
#include <random>
#include <string>

#include "drivers/measurement/angles.hpp"
#include "fusion/monitoring/calibration_supervisor.hpp"

namespace infuse::monitoring {
namespace {

/// Next state, as the first letters of its name, and the actions in the order of their bits: start,
/// cancel, use, revert, propose, withdraw, evidence anew, forget failures, want, note.
std::string text_of(const CalibrationTransition& result) {
  constexpr std::array<const char*, kCalibrationStates> kShort = {"ok",  "mon", "sus", "con",
                                                                  "run", "new", "bad"};
  std::string text = kShort[static_cast<size_t>(result.state)];
  constexpr std::string_view kLetters = "scurpwefan";
  for (size_t bit = 0; bit < kLetters.size(); ++bit) {
    if (bit == 0 && result.actions != 0) text += ' ';
    if ((result.actions >> bit & 1) != 0) text += kLetters[bit];
  }
  return text;
}

// clang-format off
constexpr const char* kExpected[kCalibrationEvents][kCalibrationStates] = {
  // ok           mon          sus          con          run           new          bad
  {"mon",        "mon",       "mon",       "mon",       "run",        "new",       "mon"},        // learning
  {"ok",         "ok",        "ok",        "ok w",      "run",        "new",       "ok"},         // holds
  {"ok",         "ok",        "sus",       "con",       "run",        "new",       "ok"},         // doubted
  {"sus",        "sus",       "sus",       "con",       "run",        "new",       "sus"},        // suspected
  {"con n",      "con n",     "con n",     "con",       "run",        "new",       "con n"},      // confirmed
  {"bad n",      "bad n",     "bad n",     "bad n",     "bad cn",     "bad n",     "bad"},        // fault
  {"ok",         "mon",       "sus",       "con",       "run",        "new",       "bad"},        // given up
  {"ok",         "mon",       "sus",       "con",       "run",        "ok n",      "bad"},        // probation passed
  {"ok",         "mon",       "sus",       "con",       "run",        "sus rn",    "bad"},        // probation failed
  {"run s",      "run s",     "run s",     "run s",     "run",        "new",       "bad"},        // scenes ready
  {"ok",         "mon",       "sus",       "con",       "mon n",      "new",       "bad"},        // failed
  {"ok",         "mon",       "sus",       "con",       "bad n",      "new",       "bad"},        // failed, the last
  {"ok",         "mon",       "sus",       "con",       "ok wefn",    "new",       "bad"},        // unmoved
  {"ok",         "mon",       "sus",       "con",       "new uwfn",   "new",       "bad"},        // allowed
  {"ok",         "mon",       "sus",       "con",       "mon pfn",    "new",       "bad"},        // proposed
  {"ok wn",      "mon wn",    "sus wn",    "con wn",    "run wn",     "new",       "bad wn"},     // outdated
  {"ok a",       "mon a",     "sus a",     "con a",     "run",        "new a",     "bad fa"},     // recalibrate
  {"new cuwfn",  "new cuwfn", "new cuwfn", "new cuwfn", "new cuwfn",  "new cuwfn", "new cuwfn"},  // apply
  {"mon cuwfn",  "mon cuwfn", "mon cuwfn", "mon cuwfn", "mon cuwfn",  "mon cuwfn", "mon cuwfn"},  // roll back
  {"ok",         "mon",       "sus",       "con",       "mon c",      "mon",       "bad"},        // freeze
};
// clang-format on

TEST(CalibrationStates, EveryEventInEveryState) {
  for (size_t event = 0; event < kCalibrationEvents; ++event) {
    for (size_t state = 0; state < kCalibrationStates; ++state) {
      EXPECT_EQ(text_of(transition(static_cast<CalibrationState>(state),
                                   static_cast<CalibrationEvent>(event))),
                kExpected[event][state])
          << event << ", " << state;
    }
  }
  EXPECT_STREQ(name_of(CalibrationState::kRecalibrating), "RECALIBRATING");
}

/// Whatever happens, in 200 random drives of 300 events: one re-estimation at a time, nothing is
/// used that was not allowed, and every pair of states that the table knows is passed.
TEST(CalibrationStates, RandomDrivesKeepTheirPromises) {
  std::mt19937_64 random(1);
  const auto one_in = [&](uint64_t n) { return random() % n == 0; };
  const auto turned = [](uint64_t degrees) {
    return geometry::exp(static_cast<double>(degrees) * kDegree * geometry::Vector6::Unit(1));
  };
  std::array<std::array<int, kCalibrationStates>, kCalibrationStates> passed{};
  for (int drive = 0; drive < 200; ++drive) {
    const auto policy = static_cast<UpdatePolicy>(random() % 3);
    CalibrationSupervisor supervisor(turned(0), {.policy = policy,
                                                 .result_delay = 1,
                                                 .probation_evaluations = 3,
                                                 .max_failures = 2,
                                                 .retry_interval = 1});
    bool running = false;
    std::optional<Eigen::Isometry3d> before;
    for (int k = 0; k < 300; ++k) {
      const CalibrationState state = supervisor.state();
      const Eigen::Isometry3d current = supervisor.current();
      const bool had_proposal = supervisor.proposal().has_value();
      const Stamp now = Stamp::from_ns(400'000'000LL * k);
      bool owner = true;
      SupervisorActions actions;
      if (one_in(30)) {
        actions = supervisor.use({turned(random() % 5), {}, one_in(2)}, now);
      } else if (one_in(30)) {
        actions = supervisor.freeze(one_in(2), now);
      } else if (one_in(20)) {
        actions = supervisor.request_recalibration(now);
      } else {
        owner = false;
        if (one_in(4)) {  // also where none runs
          Reestimate result{.T_initial = turned(random() % 3),
                            .T_camera_lidar = turned(random() % 3)};
          result.moved = one_in(3) ? 1 : 10;
          if (one_in(2)) result.reason = "unclear";
          if (one_in(2)) result.T_initial = current;
          supervisor.finish_reestimation(result);
        }
        MonitorReport report{.stamp = now, .evaluated = true};
        report.verdict.drift = static_cast<Drift>(random() % 4);
        report.verdict.evidence = static_cast<double>(random() % 3);
        if (one_in(20)) report.verdict.fault = CameraFault::kDirty;
        report.has_gain = supervisor.alternative().has_value();
        report.gain = one_in(2) ? 1 : -1;
        report.alternative_drifted = one_in(10);
        actions = supervisor.process(report, random() % 60);
      }
      ++passed[static_cast<size_t>(state)][static_cast<size_t>(supervisor.state())];
      ASSERT_FALSE(actions.start_reestimation && running);
      ASSERT_FALSE(actions.cancel_reestimation && !running);
      running = supervisor.reestimating();
      const bool on_probation = supervisor.state() == CalibrationState::kRecalibrated;
      ASSERT_EQ(supervisor.alternative().has_value(), on_probation || supervisor.proposal());
      const bool changed = supervisor.current().matrix() != current.matrix();
      ASSERT_TRUE(!changed || actions.calibration_changed);
      if (changed && !owner) {  // applied as the policy says, or put back
        ASSERT_FALSE(supervisor.frozen());
        ASSERT_TRUE(state == CalibrationState::kRecalibrating
                        ? policy != UpdatePolicy::kAlertOnly && !supervisor.proposal()
                        : supervisor.current().matrix() == before->matrix());
      }
      ASSERT_FALSE(changed && supervisor.proposal());
      ASSERT_TRUE(had_proposal || !supervisor.proposal() ||
                  state == CalibrationState::kRecalibrating);
      if (changed) before = current;
    }
  }
  EXPECT_GT(passed[4][5], 0);  // RECALIBRATING, RECALIBRATED
  EXPECT_GT(passed[5][0], 0);
  EXPECT_GT(passed[5][2], 0);
  EXPECT_GT(passed[4][6], 0);
  EXPECT_GT(passed[6][0], 0);
}

}  // namespace
}  // namespace infuse::monitoring
