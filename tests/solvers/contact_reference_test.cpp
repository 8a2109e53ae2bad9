// Joints with clearance, strips and stops against reference solutions in minimal coordinates with located
// contacts: motion, and the instants and speeds at which contacts begin.
#include "core/channels.hpp"
#include "models/mechanisms.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/reference_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {
namespace {

using testing_data::ReferenceTable;
using Parameters = std::map<std::string, std::string>;

struct Compared {
    std::string channel, column;
    double radau, gear; // largest error allowed, at tolerance 1e-9 (radau), 1e-8 (gear)
    double sign = 1;
};

struct Start {
    double t, speed; // s; m/s or rad/s, negative: not compared
    std::string place;
    int number; // of its kind; 0: the only one
};

struct ContactCase {
    std::string name, mechanism;
    Parameters parameters;
    std::string file;
    double end;
    std::vector<Compared> compared;
    std::string contacts;      // file of all contacts, or ...
    std::vector<Start> starts; // ... the first few
    int together = 1;          // channels that begin at each start
    int unlisted = 0;          // last contacts that the file leaves out since they never end
    // errors of the instants (s) and speeds of starts
    double radau_time, radau_speed, gear_time, gear_speed;
    double gear_tolerance = 1e-8;
};

struct Outcome {
    std::vector<ContactEvent> starts;
    std::vector<double> errors;
    double balance = 0;
    std::vector<ContactChannel> channels;
};

Outcome run(const ContactCase& test, const std::string& integrator, Onset onset, double tolerance) {
    Outcome out{{}, std::vector<double>(test.compared.size(), 0), 0, {}};
    SimulationOptions options;
    options.integrator = integrator;
    options.integration.rtol = options.integration.atol = tolerance;
    options.integration.onset = onset;
    options.on_contact = [&out](const ContactEvent& event) {
        if (event.kind == ContactEvent::Kind::start)
            out.starts.push_back(event);
    };
    Simulation sim(build_mechanism(test.mechanism, test.parameters), options);
    out.channels = sim.system().contacts;
    std::vector<Channels> channels;
    for (const Compared& c : test.compared)
        channels.emplace_back(sim.system(), std::vector<std::string>{c.channel});
    const ReferenceTable table(test.file);
    for (std::size_t i = 0; i < table.rows() && table["t"][i] <= test.end; ++i) {
        const double t = table["t"][i];
        if (t > 0) {
            const StepOutcome outcome = sim.advance_past(t, test.end);
            EXPECT_TRUE(outcome.ok) << outcome.message;
            if (!outcome.ok)
                break;
        }
        const Sample& sample = sim.sample_at(t);
        out.balance = std::max(out.balance, std::abs(sample.balance));
        for (std::size_t k = 0; k < channels.size(); ++k) {
            double value = 0;
            channels[k].read(sample, {&value, 1});
            const Compared& c = test.compared[k];
            out.errors[k] = std::max(out.errors[k], std::abs(c.sign * value - table[c.column][i]));
        }
    }
    return out;
}

/// Each reference contact is met by `together` channels within the bounds, and nothing else begins.
void expect_all_starts(const ContactCase& test, const Outcome& found, double time, double speed) {
    const ReferenceTable table(test.contacts);
    const bool r4 = test.mechanism == "bouncing-journal";
    const std::vector<double>& t = table["t_start"];
    const std::vector<double>& v = table[r4 ? "v_minus" : "vminus"];
    EXPECT_EQ(found.starts.size(), test.together * (t.size() + test.unlisted));
    for (std::size_t i = 0; i < t.size(); ++i) {
        int met = 0;
        for (const ContactEvent& event : found.starts)
            met += std::abs(event.t - t[i]) < time && std::abs(event.speed - v[i]) < speed;
        EXPECT_EQ(met, test.together) << "contact at " << t[i] << " s with " << v[i];
    }
}

void expect_first_starts(const ContactCase& test, const Outcome& found, double time, double speed) {
    for (const Start& start : test.starts) {
        const auto met = std::ranges::find_if(found.starts, [&](const ContactEvent& event) {
            const ContactChannel& channel = found.channels[event.channel];
            return channel.place == start.place && channel.number == start.number;
        });
        ASSERT_NE(met, found.starts.end()) << start.place << ' ' << start.number;
        EXPECT_NEAR(met->t, start.t, time) << start.place << ' ' << start.number;
        if (start.speed > 0) {
            EXPECT_NEAR(met->speed, start.speed, speed) << start.place << ' ' << start.number;
        }
    }
}

void expect_reference(const ContactCase& test, const std::string& integrator, Onset onset) {
    const bool radau = integrator == "radau";
    const double tolerance = radau                 ? 1e-9
                             : integrator == "ida" ? 0.1 * test.gear_tolerance // held to gear's bounds
                                                   : test.gear_tolerance;
    const Outcome found = run(test, integrator, onset, tolerance);
    for (std::size_t k = 0; k < test.compared.size(); ++k) {
        const Compared& c = test.compared[k];
        EXPECT_LT(found.errors[k], radau ? c.radau : c.gear) << c.channel;
    }
    EXPECT_LT(found.balance, radau ? 5e-9 : 5e-6);
    const double time = radau ? test.radau_time : test.gear_time;
    const double speed = radau ? test.radau_speed : test.gear_speed;
    if (!test.contacts.empty())
        expect_all_starts(test, found, time, speed);
    expect_first_starts(test, found, time, speed);
}

std::vector<ContactCase> cases() {
    const std::vector<Start> tilted{{0.0046922509620, 6.2189726073e-2, "strip", 1}, // the reference's notes
                                    {0.0054126479516, -1, "strip", 2},
                                    {0.0061004202639, -1, "strip", 3}};
    const auto journal = [](double r, double g) {
        return std::vector<Compared>{{"journal.x", "cx", r / 10, g / 10},
                                     {"journal.y", "cy", r, g},
                                     {"journal.z", "cz", r, g},
                                     {"journal.e0", "e0", 10 * r, 10 * g},
                                     {"journal.e1", "e1", 10 * r, 10 * g},
                                     {"journal.e2", "e2", 10 * r, 10 * g},
                                     {"journal.e3", "e3", 10 * r, 10 * g}};
    };
    return {
        // 5 s: an error of the speed at the second start grows 400 times, in theta
        {"BallInSocket",
         "slider-crank",
         {{"joint", "spherical"}},
         "r2_spherical_c100um.csv",
         5,
         {{"A.angle", "theta", 5e-6, 4e-3},
          {"slider.x", "x", 1e-7, 1e-4},
          {"slider.vx", "xd", 5e-6, 5e-3},
          {"B.dissipated", "D", 5e-8, 3e-5}},
         "r2_contacts_c100um.csv",
         {},
         1,
         0,
         1e-9,
         1e-8,
         2e-6,
         1e-5},
        {"Stops",
         "triple-pendulum",
         {},
         "r3_Z_LN.csv",
         4,
         {{"J1.angle", "q1", 1e-7, 1e-4},
          {"J2.slide", "s", 2e-7, 2e-4},
          {"J2.angle", "phi", 5e-8, 3e-5},
          {"J3.angle", "psi", 1e-7, 1e-4}},
         "r3_Z_LN_contacts.csv",
         {},
         1,
         0,
         2e-7,
         2e-7,
         2e-4,
         2e-4},
        {"Bouncing",
         "bouncing-journal",
         {},
         "r4_LN_e75.csv",
         1,
         {{"journal.z", "u", 1e-9, 1e-6, -1}, {"journal.vz", "v", 3e-7, 4e-4, -1}},
         "r4_LN_e75_contacts.csv",
         {},
         8,
         1,
         1e-8,
         1e-8,
         1e-5,
         5e-5},
        // 22 contacts of 1e-4 s, the last one at 1 mm/s: only the fine tolerance finds them all
        {"BouncingOnSteel",
         "bouncing-journal",
         {{"law", "cylinder"}},
         "r4_CYL_e75.csv",
         1,
         {{"journal.z", "u", 2e-9, 5e-8, -1}, {"journal.vz", "v", 1e-4, 2e-3, -1}},
         "r4_CYL_e75_contacts.csv",
         {},
         8,
         1,
         1e-7,
         1e-7,
         5e-5,
         5e-5,
         1e-10},
        {"Tilted",
         "tilted-journal",
         {},
         "r9_a_clipped.csv",
         0.2,
         journal(2e-9, 2e-7),
         "",
         tilted,
         1,
         0,
         2e-10,
         1e-9,
         2e-8,
         1e-6},
        {"TiltedElastic",
         "tilted-journal",
         {{"restitution", "1"}},
         "r9_d.csv",
         0.2,
         journal(5e-8, 5e-6),
         "",
         {tilted[0]}, // the same flight until then
         1,
         0,
         2e-10,
         1e-9,
         2e-8,
         1e-6},
        {"WornCrankBearing",
         "slider-crank",
         {{"joint", "revolute"}},
         "r10_mid_c100um_clipped.csv",
         0.5,
         {{"slider.x", "x", 1e-9, 1e-6},
          {"crank.e0", "e0", 1e-8, 1e-5},
          {"crank.e1", "e1", 1e-8, 1e-5},
          {"crank.e2", "e2", 1e-8, 1e-5},
          {"crank.e3", "e3", 1e-8, 1e-5}},
         "",
         {{0.0049734963544, 4.0438892334e-2, "strip", 8}, {0.0090607289369, -1, "end face", 0}},
         1,
         0,
         1e-10,
         1e-9,
         1e-6,
         1e-5},
    };
}

struct How {
    ContactCase test;
    std::string integrator;
    Onset onset;
};

void PrintTo(const How& how, std::ostream* out) { *out << how.test.name; }

std::vector<How> every_way() {
    std::vector<How> all;
    for (const ContactCase& test : cases())
        for (const char* integrator : {"radau", "gear", "ida"})
            for (const Onset onset : {Onset::threshold, Onset::root})
                all.push_back({test, integrator, onset});
    return all;
}

class ContactsAgainst : public testing::TestWithParam<How> {};

TEST_P(ContactsAgainst, Reference) {
    expect_reference(GetParam().test, GetParam().integrator, GetParam().onset);
}

INSTANTIATE_TEST_SUITE_P(Slow, ContactsAgainst, testing::ValuesIn(every_way()), [](const auto& info) {
    return info.param.test.name + '_' + info.param.integrator +
           (info.param.onset == Onset::root ? "_root" : "_threshold");
});

// Each power of ten of the tolerance counts: the contacts do not hide a limit of their own. A single loose
// run may be right by luck, so the worst of three stands for them.
TEST(ContactReferences, ErrorsFallWithTheTolerance) {
    for (const ContactCase& test : cases()) {
        if (test.end > 4 || test.name == "BouncingOnSteel")
            continue; // long, or with speeds that change within one sample
        for (const char* integrator : {"radau", "gear"}) {
            SCOPED_TRACE(test.name + " by " + integrator);
            Outcome loose = run(test, integrator, Onset::threshold, 1e-5);
            for (const double tolerance : {5e-6, 2e-5}) {
                const Outcome other = run(test, integrator, Onset::threshold, tolerance);
                loose.errors[1] = std::max(loose.errors[1], other.errors[1]);
                loose.balance = std::max(loose.balance, other.balance);
            }
            const Outcome fine = run(test, integrator, Onset::threshold, 1e-8);
            EXPECT_LT(fine.errors[1], loose.errors[1] / 50);
            EXPECT_LT(fine.balance, loose.balance / 50);
        }
    }
}

} // namespace
} // namespace gudgeon
