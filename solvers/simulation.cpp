#include "solvers/simulation.hpp"

#include "contact/standard_forces.hpp"
#include "core/archive.hpp"
#include "core/bad_numbers.hpp"
#include "core/matrices.hpp"
#include "core/writer.hpp"
#include "solvers/break_times.hpp"
#include "solvers/consistent.hpp"
#include "solvers/notices.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/singular_position.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace gudgeon {

namespace {

System compile_all(Model model, const SimulationOptions& options) {
    std::vector<ForceBatchBuilder> builders = standard_force_builders();
    if (!options.user_forces.empty())
        builders.push_back(user_force_builder(options.user_forces));
    return compile(std::move(model), builders);
}

} // namespace

struct Simulation::Impl {
    System system;
    State start;
    AssemblyReport assembly;
    RedundancyReport redundancy;
    std::optional<StaticsReport> statics;
    std::vector<std::string> notices;
    std::vector<RankChange> rank_changes;
    int deficiency = 0, repeated = 0; // of the last sample: by pivots, by rank
    std::unique_ptr<Integrator> integrator;
    const std::shared_ptr<ConsistentSolver> projections; // the integrator's too
    ConsistentSolver& consistent;                        // projections
    Workspace ws;                                        // for samples
    Sample sample;
    State now; // state at time()
    std::vector<double> breaks;
    double balance_start = 0, output_seconds = 0;
    Statistics statistics;
    SimulationOptions options;
    std::uint64_t model_sum = 0; // of its text, 0: not formed yet

    Impl(Model model, const SimulationOptions& given)
        : system(compile_all(std::move(model), given)), start(initial_state(system)),
          projections(std::make_shared<ConsistentSolver>(system)), consistent(*projections),
          ws(make_workspace(system)), options(given) {
        breaks = break_times(system.model);
        assemble();
        if (options.start == Start::equilibrium)
            rest();
        else
            notices = start_notices(system, start);
        require_numbers(start);
        IntegratorOptions integration = options.integration;
        integration.redundant = !redundancy.dependent.empty();
        integration.projections = projections;
        repeated = static_cast<int>(redundancy.dependent.size());
        if (integration.redundant)
            consistent.soften();
        integrator = make_integrator(options.integrator, system, integration);
        integrator->set_on_contact(options.on_contact);
        integrator->start(start);
        now = integrator->state();
        make_sample(now);
        balance_start = sample.energies.mechanical();
        sample.balance = 0;
    }

    /// One step that passes neither t_end nor a time where forces stir.
    StepOutcome advance(double t_end) {
        const auto next = std::upper_bound(breaks.begin(), breaks.end(), integrator->state().t);
        const bool ahead = next != breaks.end() && *next <= t_end;
        StepOutcome outcome = integrator->advance(ahead ? *next : t_end);
        if (ahead && integrator->state().t == *next)
            integrator->kink();
        return outcome;
    }

    void assemble() {
        assembly = assemble_start(system, start, consistent);
        if (!assembly.ok)
            throw AssemblyError("the mechanism cannot be assembled: " + assembly.message(system), assembly);
        redundancy = find_redundancy(system, start);
        if (redundancy.dependent.empty())
            return;
        if (const std::string why = undecided_start(system, start); !why.empty())
            throw AssemblyError("the mechanism cannot start: " + why, assembly);
    }

    // Pivots tell cheaply that the rank may have changed; then it is found out.
    void watch_rank(const State& s) {
        constexpr std::size_t most = 100;
        if (!consistent.soft())
            return;
        const int found = consistent.deficiency();
        if (found == std::exchange(deficiency, found))
            return;
        RedundancyReport report = find_redundancy(system, s);
        const int now = static_cast<int>(report.dependent.size());
        if (now != std::exchange(repeated, now) && rank_changes.size() < most)
            rank_changes.push_back({s.t, std::move(report)});
    }

    // At a singular position constraints close only as far as the integrator closed them: then the state is
    // taken as it is.
    bool close(State& s) {
        const VecX q = s.q, u = s.u;
        if (consistent.project_positions(s.t, s.q, s.u, ws) &&
            consistent.project_velocities(s.t, s.q, s.u, ws))
            return true;
        s.q = q;
        s.u = u;
        return consistent.soft();
    }

    void rest() {
        statics = find_equilibrium(system, start);
        if (!statics->ok)
            throw EquilibriumError(statics->message, *statics);
        notices = statics->notices();
    }

    // What has to be the same for a checkpoint to fit.
    void visit_identity(Archive& archive) {
        if (model_sum == 0)
            model_sum = crc64(write_model(system.model));
        archive.same(std::string(GUDGEON_VERSION), "another version of the program");
        archive.same(system.model.name, "another model");
        archive.same(model_sum, fmt::format("another model of the name '{}', or the model was changed",
                                            system.model.name));
        archive.same(system.forces.size(), "a model with other user forces");
        for (const auto& batch : system.forces)
            archive.same(batch->size(), "a model with other user forces");
        const IntegratorOptions& o = options.integration;
        archive.same(options.integrator, "another integrator");
        for (const double x : {o.rtol, o.atol, o.step})
            archive.same(x, "other tolerances or another step");
        archive.same(o.max_order, "another highest order");
        archive.same(o.onset, "another rule for the onset of contacts");
        archive.same(o.formulation, "another formulation");
        archive.same(o.max_steps, "another greatest number of steps");
    }

    void visit(Archive& archive) {
        archive.section("simulation");
        visit_identity(archive);
        integrator->visit(archive);
        bool soft = consistent.soft();
        archive(now, balance_start, output_seconds, soft, deficiency, repeated, rank_changes);
        if (archive.reading() && soft)
            consistent.soften();
    }

    // Forces, drives and coordinates at a state are finite numbers.
    void require_numbers(const State& s) {
        ws.remember(s);
        if (integrator)
            ws.external = integrator->workspace().external;
        set_motion(system, s.q, s.u, ws);
        if (const std::string found = find_bad_number(system, s.t, ws); !found.empty())
            throw BadNumberError(found);
    }

    // Closes the constraints of a state and evaluates everything there.
    void make_sample(const State& state) {
        const PhaseTimer timer(output_seconds);
        sample.state = state;
        ws.remember(state);
        ws.external = integrator->workspace().external;
        State& s = sample.state;
        if (!close(s) || !consistent.accelerations(s.t, s.q, s.u, ws, sample.acceleration, s.lambda))
            throw std::runtime_error(fmt::format("the sample at t = {:.9g} s has no consistent state: "
                                                 "constraints open by {:.3g} (position), {:.3g} "
                                                 "(velocity), or repeating each other",
                                                 s.t, consistent.worst_position(),
                                                 consistent.worst_velocity()));
        watch_rank(s);
        sample.motion = ws.motion;
        sample.energies = energies(system, s.t, s.lambda.data(), ws);
        sample.balance = sample.energies.mechanical() + s.dissipated() - s.input() - balance_start;
        sample_contacts(system, s.t, ws);
        sample.contacts = joint_contacts(system, ws);
        joint_wrenches(system, s.t, s.lambda, ws, sample.joint);
        require_finite_sample();
    }

    void require_finite_sample() {
        bool good = sample.acceleration.allFinite() && sample.state.lambda.allFinite() &&
                    sample.state.work.allFinite() && std::isfinite(sample.energies.mechanical());
        for (const Wrench& w : sample.joint)
            good = good && w.force.allFinite() && w.moment.allFinite();
        if (good)
            return;
        require_numbers(State(sample.state));
        throw BadNumberError(fmt::format(
            "no finite number at t = {:.9g} s: accelerations, reactions or energies of the sample",
            sample.state.t));
    }
};

Simulation::Simulation(Model model, SimulationOptions options)
    : impl_(std::make_unique<Impl>(std::move(model), options)) {}
Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

const System& Simulation::system() const { return impl_->system; }
const AssemblyReport& Simulation::assembly() const { return impl_->assembly; }
const RedundancyReport& Simulation::redundancy() const { return impl_->redundancy; }
const std::vector<RankChange>& Simulation::rank_changes() const { return impl_->rank_changes; }
const StaticsReport* Simulation::statics() const { return impl_->statics ? &*impl_->statics : nullptr; }
const std::vector<std::string>& Simulation::notices() const { return impl_->notices; }
const char* Simulation::integrator_name() const { return impl_->integrator->name(); }
std::vector<IntegratorUse> Simulation::integrator_uses() const {
    std::vector<IntegratorUse> uses = impl_->integrator->uses();
    if (uses.empty())
        uses.push_back({impl_->start.t, impl_->integrator->name(), "asked for"});
    return uses;
}
const char* Simulation::linear_solver() const { return impl_->integrator->linear_solver(); }
const char* Simulation::formulation() const { return impl_->integrator->formulation(); }
Integrator& Simulation::integrator() { return *impl_->integrator; }
double Simulation::time() const { return impl_->now.t; }

const Statistics& Simulation::statistics() const {
    impl_->statistics = impl_->integrator->statistics();
    impl_->statistics.seconds.output = impl_->output_seconds;
    return impl_->statistics;
}

StepOutcome Simulation::advance_to(double t) {
    Integrator& integrator = *impl_->integrator;
    while (integrator.state().t < t) {
        const StepOutcome outcome = impl_->advance(t);
        if (!outcome.ok) {
            impl_->now = integrator.state();
            return outcome;
        }
    }
    impl_->now = integrator.state();
    return {};
}

StepOutcome Simulation::advance_past(double t, double t_end) {
    Integrator& integrator = *impl_->integrator;
    while (integrator.state().t < t) {
        const StepOutcome outcome = impl_->advance(t_end);
        impl_->now = integrator.state();
        if (!outcome.ok)
            return outcome;
    }
    return {};
}

const Sample& Simulation::sample() {
    impl_->make_sample(impl_->now);
    return impl_->sample;
}

const Sample& Simulation::sample_at(double t) {
    State at;
    if (t == impl_->integrator->state().t)
        at = impl_->integrator->state();
    else
        impl_->integrator->interpolate(t, at);
    impl_->make_sample(at);
    return impl_->sample;
}

State Simulation::state() const { return impl_->now; }

void Simulation::restore(const State& state) {
    if (state.q.size() != impl_->system.positions() || state.u.size() != impl_->system.velocities())
        throw std::invalid_argument("the state belongs to another system");
    impl_->integrator->start(state);
    impl_->now = impl_->integrator->state();
}

void Simulation::visit(Archive& archive) { impl_->visit(archive); }

void Simulation::save(std::ostream& stream) {
    Archive archive;
    visit(archive);
    write_sealed(stream, archive);
}

void Simulation::load(std::istream& stream) {
    Archive archive = read_sealed(stream);
    visit(archive);
    archive.finish();
}

void Simulation::set_load(const std::string& body, const Vec3& force, const Vec3& moment) {
    const int i = impl_->system.body_index(body);
    if (i < 0)
        throw std::invalid_argument("no body named '" + body + "'");
    if (i >= impl_->system.moving)
        return; // the ground bears it
    Integrator& integrator = *impl_->integrator;
    integrator.workspace().external.segment<3>(6 * i) = force;
    integrator.workspace().external.segment<3>(6 * i + 3) = moment;
    integrator.start(impl_->now);
}

Simulation::Matrices Simulation::matrices() {
    const System& s = impl_->system;
    const State& now = impl_->now;
    Workspace& ws = impl_->ws;
    ws.angles = now.angles;
    ws.contacts = now.contacts;
    ws.z = now.z;
    VecX lambda = now.lambda, acceleration;
    if (impl_->options.integration.formulation == Formulation::tree) // it goes without those of its joints
        impl_->consistent.accelerations(now.t, now.q, now.u, ws, acceleration, lambda);
    set_motion(s, now.q, now.u, ws);
    linearise(s, now.t, lambda.data(), ws);
    return {mass_matrix(s), blocks_as_matrix(s, ws.lin.C), blocks_as_matrix(s, ws.lin.S),
            rows_as_matrix(s, ws)};
}

} // namespace gudgeon
