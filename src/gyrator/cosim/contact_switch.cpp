#include "gyrator/cosim/contact_switch.hpp"

namespace gyrator {

using Eigen::Index;

const std::string& ContactSwitch::name_of(int guard) const {
  return modes_.name(now_->guards[static_cast<std::size_t>(guard)].part);
}

void ContactSwitch::enter(const Modes& modes) {
  if (now_ && now_->key == modes) return;
  for (const auto& known : known_) {
    if (known->key == modes) {
      now_ = known.get();
      return;
    }
  }
  known_.push_back(std::make_unique<Known>(
      Known{modes, modes_.close(modes).middleRows(2, 3), modes_.guards(modes)}));
  now_ = known_.back().get();
}

void ContactSwitch::close(Eigen::VectorXd& z) {
  efforts_.noalias() = now_->closed * z;
  z.segment<3>(plant_.states() + 2) = efforts_;
}

double ContactSwitch::value(int guard, const Eigen::VectorXd& z) const {
  return now_->guards[static_cast<std::size_t>(guard)].row.dot(z);
}

double ContactSwitch::size(int guard, const Eigen::VectorXd& sizes) const {
  const Eigen::RowVectorXd& row = now_->guards[static_cast<std::size_t>(guard)].row;
  const Index n = plant_.states();
  return row.head(n).cwiseAbs().dot(sizes.head(n)) + std::abs(row(row.size() - 1));
}

void ContactSwitch::change(int guard, Modes& modes, Eigen::Ref<Eigen::MatrixXd> xi) {
  const ModeGuard& crossed = now_->guards[static_cast<std::size_t>(guard)];
  modes[crossed.part] = crossed.next;
  if (modes_.comes_to_rest(crossed)) modes_.hold_shaft(xi);
  enter(modes);
}

void ContactSwitch::count(int guard, ContactEvents& events) const {
  const ModeGuard& crossed = now_->guards[static_cast<std::size_t>(guard)];
  events.count(crossed, now_->key[crossed.part]);
}

void ContactSwitch::hold(Eigen::Ref<Eigen::MatrixXd> xi) const {
  if (modes_.sticks(now_->key)) modes_.hold_shaft(xi);
}

std::vector<Modes> ContactSwitch::touching() const {
  std::vector<Modes> touching;
  const auto& stops = plant_.nonlinear->contacts->stops;
  if (stops && stops->upper) touching.push_back({1, 1});
  if (stops && stops->lower) touching.push_back({1, -1});
  return touching;
}

}  // namespace gyrator
