#include "contact/strip_touches.hpp"

namespace gudgeon {

PointFriction StripBatch::friction_of(const Evaluation& e, const StripJoint& x, const Touch& touch) const {
    return point_friction(*x.friction, x.states(e, touch.place), e.body[x.a], e.body[x.b], touch.point,
                          touch.f.force);
}

void StripBatch::declare_states(std::vector<double>& scales) {
    for (StripJoint& x : joints_.items()) {
        if (!x.friction || !x.friction->has_state())
            continue;
        x.state = static_cast<int>(scales.size());
        scales.insert(scales.end(), 3 * std::size_t(x.strips * most_points), x.friction->state_scale());
        states_ += x.strips * most_points;
    }
}

void StripBatch::state_terms(const Evaluation& e, double* source, double* decay) const {
    if (states_ == 0)
        return;
    in_parallel(e, size(), [&](int j) {
        const StripJoint& x = joints_.items()[j];
        if (x.state < 0)
            return;
        for (int place = 0; place < x.strips * most_points; ++place)
            free_state_terms(*x.friction, source + x.state + 3 * place, decay + x.state + 3 * place);
        if (const std::optional<Pose> pose = in_reach(e, x))
            for_touches(e, x, *pose, [&](const Touch& touch) {
                const int state = x.state + 3 * touch.place;
                point_state_terms(friction_of(e, x, touch), e.body[x.a], source + state, decay + state);
            });
    });
}

// Listed joint by joint in the order of their states.
void StripBatch::add_state_couplings(const Evaluation& e, Linearisation& lin) const {
    if (states_ == 0)
        return;
    const std::size_t first = lin.states.size();
    for (const StripJoint& x : joints_.items())
        for (int place = 0; x.state >= 0 && place < x.strips * most_points; ++place)
            add_couplings(free_state_couplings(*x.friction), x.state + 3 * place, x, lin);
    const int first_state = lin.states[first].state;
    in_parallel(e, size(), [&](int j) {
        const StripJoint& x = joints_.items()[j];
        if (x.state < 0)
            return;
        const std::optional<Pose> pose = in_reach(e, x);
        if (!pose)
            return;
        for_touches(e, x, *pose, [&](const Touch& touch) {
            const auto found =
                point_state_couplings(friction_of(e, x, touch), e.body[x.a], e.body[x.b], touch.point);
            const std::size_t own = first + std::size_t(x.state - first_state) + 3 * std::size_t(touch.place);
            for (int i = 0; i < 3; ++i) {
                lin.states[own + i].decay = found[i].decay;
                lin.states[own + i].force = found[i].force;
                lin.states[own + i].rate = found[i].rate;
            }
        });
    });
}

} // namespace gudgeon
