#include "solvers/break_times.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

struct Collector {
    std::vector<double>& times;

    void operator()(const ConstantFunction&) const {}
    void operator()(const HarmonicFunction&) const {}
    void operator()(const SmoothStepFunction& f) const {
        times.push_back(f.start);
        times.push_back(f.end);
    }
    void operator()(const RampFunction& f) const { times.push_back(f.start); }
    void operator()(const TableFunction& f) const {
        const auto& [x, y] = f.table();
        for (std::size_t i = 0; i + 1 < x.size(); ++i)
            if ((i == 0 || y[i] == y[i - 1]) && y[i + 1] != y[i]) {
                times.push_back(x[i]);
                times.push_back(x[i + 1]);
            }
    }
    void operator()(const SharedPart<TimeFunction>& f) const {
        if (f)
            std::visit(*this, *f);
    }
};

} // namespace

std::vector<double> break_times(const Model& model) {
    std::vector<double> times;
    const Collector collect{times};
    for (const Joint& joint : model.joints)
        for (const auto& [coordinate, drive] : joint.drives)
            std::visit(collect, drive);
    for (const Force& force : model.forces) {
        if (const auto* applied = std::get_if<AppliedForce>(&force))
            collect(applied->time);
        else if (const auto* spring = std::get_if<SpringDamper>(&force))
            collect(spring->actuator);
        else if (const auto* tyre = std::get_if<Tyre>(&force))
            collect(tyre->road);
    }
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    return times;
}

} // namespace gudgeon
