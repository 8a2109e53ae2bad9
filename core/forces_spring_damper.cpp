#include "core/forces_spring_damper.hpp"

#include "core/elastic_law.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

namespace {

using Element = SpringDamperKernel::Element;

// Length, direction (zero where there is none) and rate of the line.
struct Line {
    double length, rate;
    Vec3 n;
};

Line line(const Evaluation& e, const Element& x) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Vec3 d = point_position(b, x.sb) - point_position(a, x.sa);
    const double length = d.norm();
    if (length <= SpringDamperKernel::shortest)
        return {length, 0, Vec3::Zero()};
    const Vec3 n = d / length;
    return {length, n.dot(point_velocity(b, x.sb) - point_velocity(a, x.sa)), n};
}

CurveValue elastic(const Element& x, double length) {
    const Spline* table = x.extra && !x.extra->table.empty() ? &x.extra->table : nullptr;
    CurveValue v = elastic_law(x.stiffness, table, length - x.free_length);
    v.value += x.constant;
    v.integral += x.constant * (length - x.free_length);
    return v;
}

double actuator(const Evaluation& e, const Element& x) {
    return x.extra && x.extra->actuator ? evaluate(*x.extra->actuator, e.t).value : 0;
}

double tension(const Evaluation& e, const Element& x, const Line& l, const CurveValue& spring) {
    return spring.value + x.damping * l.rate + actuator(e, x);
}

// out += factor J^T J with J the gradient of d = P_b - P_a; turn: its parts A skew(s).
void add_transverse(double factor, const BodyMotion& a, const BodyMotion& b, const Element& x,
                    BlockMatrix& out) {
    const Mat3 turn_a = factor * a.A * skew(x.sa), turn_b = factor * b.A * skew(x.sb);
    const Mat3 unit = factor * Mat3::Identity();
    const auto square = [&](const Vec3& s) -> Mat3 {
        return s.squaredNorm() * unit - factor * s * s.transpose();
    };
    out.block[0][0] += unit;
    out.block[0][1] -= turn_a;
    out.block[0][2] -= unit;
    out.block[0][3] += turn_b;
    out.block[1][0] -= turn_a.transpose();
    out.block[1][1] += square(x.sa);
    out.block[1][2] += turn_a.transpose();
    out.block[2][0] -= unit;
    out.block[2][1] += turn_a;
    out.block[2][2] += unit;
    out.block[2][3] -= turn_b;
    out.block[3][0] += turn_b.transpose();
    out.block[3][2] -= turn_b.transpose();
    out.block[3][3] += square(x.sb);
    const Mat3 both = skew(x.sa) * (a.A.transpose() * turn_b); // -turn_a^T turn_b / factor
    out.block[1][3] += both;
    out.block[3][1] += both.transpose();
}

} // namespace

PairWrench SpringDamperKernel::wrench(const Evaluation& e, const Element& x) {
    const Line l = line(e, x);
    const Vec3 force = tension(e, x, l, elastic(x, l.length)) * l.n;
    return {force, x.sa.cross(e.body[x.a].A.transpose() * force), -force,
            -x.sb.cross(e.body[x.b].A.transpose() * force)};
}

// With J the gradient of d = P_b - P_a and B = n^T J the one of l:
// S = B^T ((k - T/l) B + c D) + T/l J^T J + geometric stiffness of J.
void SpringDamperKernel::linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s) {
    const BodyMotion &a = e.body[x.a], &b = e.body[x.b];
    const Line l = line(e, x);
    const CurveValue spring = elastic(x, l.length);
    const double t = tension(e, x, l, spring);
    const bool short_line = l.length <= shortest;
    const double transverse = short_line ? spring.slope : t / l.length;

    add_transverse(transverse, a, b, x, s);
    point_difference::add_geometric(a, b, x.sa, x.sb, t * l.n, s);
    if (short_line)
        return;
    const Gradient<1> g = distance::gradient(a, b, x.sa, x.sb);
    const Gradient<1> rate = distance::rate_gradient(a, b, x.sa, x.sb);
    add_product(g, combined(spring.slope - transverse, g, x.damping, rate), s);
    add_product(g, combined(x.damping, g, 0, g), c);
}

EnergyRates SpringDamperKernel::energies(const Evaluation& e, const Element& x) {
    const Line l = line(e, x);
    return {elastic(x, l.length).integral, x.damping * l.rate * l.rate, -actuator(e, x) * l.rate};
}

namespace {

// Root of curve(x) = y in [low, high], where curve - y changes sign.
double bisect(const Spline& curve, double y, double low, double high) {
    const bool rising = curve(low).value <= y;
    while (true) {
        const double middle = 0.5 * (low + high);
        if (middle <= low || middle >= high)
            return middle;
        ((curve(middle).value <= y) == rising ? low : high) = middle;
    }
}

} // namespace

std::optional<double> elongation_for(const Table& table, double tension) {
    const Spline curve(table, Spline::Ends::linear);
    std::optional<double> best;
    const auto offer = [&](double x) {
        if (!best || std::abs(x) < std::abs(*best))
            best = x;
    };
    for (std::size_t i = 0; i + 1 < table.x.size(); ++i)
        if ((table.y[i] - tension) * (table.y[i + 1] - tension) <= 0)
            offer(bisect(curve, tension, table.x[i], table.x[i + 1]));
    // The straight continuations.
    const double first = curve(table.x.front()).slope, last = curve(table.x.back()).slope;
    const double before = (tension - table.y.front()) / first, after = (tension - table.y.back()) / last;
    if (first != 0 && before < 0)
        offer(table.x.front() + before);
    if (last != 0 && after > 0)
        offer(table.x.back() + after);
    return best;
}

namespace {

void set_free_length(const CompileContext& context, std::size_t number, const SpringDamper& spring,
                     double length, Element& x) {
    x.free_length = spring.free_length.value_or(length);
    if (!spring.preload)
        return;
    x.free_length = length;
    if (!spring.table.empty()) {
        const auto elongation = elongation_for(spring.table, *spring.preload);
        if (!elongation)
            throw ModelError(context.model.source, fmt::format("/forces/{}/preload", number),
                             fmt::format("no elongation gives {} N", *spring.preload),
                             "a tension that the table reaches");
        x.free_length -= *elongation;
    } else if (spring.stiffness != 0) {
        x.free_length -= *spring.preload / spring.stiffness;
    } else {
        x.constant = *spring.preload;
    }
}

} // namespace

std::unique_ptr<ForceBatch> build_spring_dampers(const CompileContext& context) {
    auto batch = std::make_unique<ForceBatchOf<SpringDamperKernel>>();
    for (std::size_t i = 0; i < context.model.forces.size(); ++i) {
        const auto* spring = std::get_if<SpringDamper>(&context.model.forces[i]);
        if (!spring)
            continue;
        Element x;
        x.a = context.body(spring->bodies[0]);
        x.b = context.body(spring->bodies[1]);
        x.sa = spring->body_frame ? spring->points[0] : context.in_body(x.a, spring->points[0]);
        x.sb = spring->body_frame ? spring->points[1] : context.in_body(x.b, spring->points[1]);
        x.stiffness = spring->stiffness;
        x.damping = spring->damping;
        if (!spring->table.empty() || spring->actuator) {
            SpringDamperKernel::Extra extra;
            if (!spring->table.empty())
                extra.table = Spline(spring->table, Spline::Ends::linear);
            extra.actuator = spring->actuator;
            x.extra = std::make_shared<const SpringDamperKernel::Extra>(std::move(extra));
        }
        const auto& start = context.system.start;
        set_free_length(context, i, *spring, distance::value(start[x.a], start[x.b], x.sa, x.sb), x);
        batch->add(std::move(x), spring->name);
    }
    if (batch->size() == 0)
        return nullptr;
    return batch;
}

} // namespace gudgeon
