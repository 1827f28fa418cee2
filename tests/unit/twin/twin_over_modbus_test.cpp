// The twin behind everything that lies between it and an experiment: port, link, sockets, server.
#include "gyrator/amplifiers/amplifier_session.hpp"
#include "gyrator/amplifiers/modbus_bench.hpp"
#include "gyrator/twin/twin_bench.hpp"
#include "gyrator/twin/twin_server.hpp"

#include <cmath>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "unit/twin/twin_models.hpp"

namespace gyrator {
namespace {

TwinDevice make_device() {
  TwinDevice twin = make_plain_twin();
  twin.thermal = {8, 3};
  twin.noise = {0, 1e-3, 5e-3, 0.02, 0};
  twin.position_quantum = 1e-4;
  twin.device.mechanics.coulomb_friction = 1e-3;
  return twin;
}

// In a thread of its own, its time that of the requests.
class ServedTwin {
 public:
  explicit ServedTwin(const DeviceProfile& profile)
      : amplifier_(make_device()),
        bank_(amplifier_, profile, {std::nullopt, ""}),
        server_(bank_, {.unit = profile.link.unit},
                make_twin_hooks(bank_, {std::nullopt, 1e-3, std::nullopt}, {}, 1)) {
    address_.host = "127.0.0.1";
    address_.port = server_.listen(address_.host, 0);
    thread_ = std::thread([this] {
      while (!server_.poll(0.1)) {
      }
    });
  }
  ~ServedTwin() {
    server_.stop();
    thread_.join();
  }
  ServedTwin(const ServedTwin&) = delete;
  ServedTwin& operator=(const ServedTwin&) = delete;

  const TcpAddress& address() const { return address_; }

 private:
  SimulatedAmplifier amplifier_;
  TwinBank bank_;
  ModbusServer server_;
  TcpAddress address_;
  std::thread thread_;
};

class TwinOverModbus : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Shipped, TwinOverModbus, testing::Values("gyrator_twin", "integer_drive"));

TEST_P(TwinOverModbus, AnExperimentIsTheOneInProcess) {
  const DeviceProfile profile = load_device_profile(GetParam());
  ServedTwin served(profile);
  ModbusLink link(served.address(), make_link_options(profile));
  PortOptions options;
  options.apply = true;
  AmplifierPort port(profile, link, options);
  ModbusBench bench(port);
  SimulatedAmplifier twin(make_device());
  TwinBench expected(twin);

  const Excitation chirp{ExcitationKind::chirp, DriveMode::voltage, 2, 0.5, 5, 200, 0.25};
  const CaptureRequest request{0.01, 2e-4, 600};
  const Capture a = bench.run(chirp, request);
  const Capture b = expected.run(chirp, request);
  const auto expect_same = [](const std::vector<double>& over, const std::vector<double>& in,
                              double resolution) {
    ASSERT_EQ(over.size(), in.size());
    for (std::size_t k = 0; k < in.size(); ++k)
      ASSERT_NEAR(over[k], in[k], resolution + 1e-6 * std::abs(in[k])) << k;
  };
  // The integer drive's registers have 0.5 mA, 2 mV, 0.01 rad/s and 0.1 mrad.
  const bool whole = profile.capture->find(CaptureSignal::current)->type == RegisterType::i16;
  expect_same(a.command, b.command, whole ? 0.5e-3 : 0);
  expect_same(a.current, b.current, whole ? 0.25e-3 : 0);
  expect_same(a.voltage, b.voltage, whole ? 1e-3 : 0);
  expect_same(a.velocity, b.velocity, whole ? 5e-3 : 0);
  expect_same(a.position, b.position, whole ? 0.5e-4 : 1e-9);
  EXPECT_EQ(port.read_value("enable"), 0);
}

}  // namespace
}  // namespace gyrator
