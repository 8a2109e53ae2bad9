// Wrong command lines, one by one: exit 2, and the message names option, value and what is allowed.
#include "app/command_tools.hpp"

#include "app/arguments.hpp"
#include "app/exit_codes.hpp"

namespace gudgeon {
namespace {

using test::command;
using test::CommandTest;
using test::Outcome;

using Words = std::vector<std::string>;

void expect_refused(const Words& args, const Words& says) {
    const Outcome outcome = command(args);
    EXPECT_EQ(outcome.code, 2) << ::testing::PrintToString(args);
    EXPECT_EQ(outcome.out, "");
    for (const std::string& word : says)
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err << "lacks " << word;
}

TEST(Arguments, NumbersOutOfRange) {
    for (const char* option : {"--rtol", "--atol", "--step", "--end", "--every", "--threads", "--max-order"})
        for (const char* value : {"0", "-1", "nan", "inf", "1e999", "abc", "1e-3x", ""}) {
            const Outcome outcome = command({"run", "pendulum", std::string(option) + "=" + value});
            EXPECT_EQ(outcome.code, 2) << option << ' ' << value;
            EXPECT_NE(outcome.err.find(option), std::string::npos) << outcome.err;
            EXPECT_NE(outcome.err.find(value), std::string::npos) << outcome.err;
            EXPECT_NE(outcome.err.find("allowed"), std::string::npos) << outcome.err;
        }
    expect_refused({"run", "pendulum", "--rtol", "-1"}, {"--rtol", "-1", "numbers from"});
    expect_refused({"run", "pendulum", "--rtol", "2"}, {"--rtol", "up to 1"});
    expect_refused({"run", "pendulum", "--threads", "1.5"}, {"--threads", "1.5", "whole numbers"});
    expect_refused({"run", "pendulum", "--max-order", "6"}, {"--max-order", "6", "1 to 5"});
    expect_refused({"run", "pendulum", "--every", "1e-12"}, {"--every", "output times"});
}

TEST(Arguments, UnknownWords) {
    expect_refused({"run", "pendulum", "--integrator", "gera"},
                   {"--integrator", "'gera'", "did you mean 'gear'?",
                    "auto, gear, radau, ida, rk4, erk, erk5, erk8, bayo"});
    expect_refused({"run", "pendulum", "--formulation", "index-3"},
                   {"'index-3'", "saddle-point, saddle-point-klu, augmented-lagrangian, tree, auto"});
    for (const char* integrator : {"ida", "rk4"})
        expect_refused(
            {"run", "pendulum", "--formulation", "augmented-lagrangian", "--integrator", integrator},
            {"--formulation", integrator, "gear, radau"});
    for (const char* integrator : {"ida", "bayo"})
        expect_refused({"run", "pendulum", "--formulation", "tree", "--integrator", integrator},
                       {"--formulation", integrator, "--formulation tree works with auto, gear, radau, rk4"});
    expect_refused({"run", "pendulum", "--formulation", "saddle-point", "--integrator", "bayo"},
                   {"--formulation", "bayo", "augmented-lagrangian"});
    expect_refused({"run", "pendulum", "--start", "anywhere"}, {"'anywhere'", "as-given, equilibrium"});
    expect_refused({"run", "pendulum", "--fast"}, {"--fast"});
    expect_refused({"simulate", "pendulum"}, {"'simulate'", "run, check, statics, modes, list, export"});
    expect_refused({"chekc", "pendulum"}, {"did you mean 'check'?"});
    expect_refused({"run", "pendulum", "chain"}, {"chain"});
    expect_refused({"list", "pendulum"}, {"pendulum"});
    expect_refused({"run"}, {"MODEL"});
    expect_refused({}, {"allowed"});
    expect_refused({"run", "pendulum", "--rtol", "1e-3", "--rtol", "1e-4"}, {"--rtol"});
    expect_refused({"run", "pendulum", "--out", ""}, {"--out"});
    expect_refused({"run", "pendulum", "--channels", "a,,b"}, {"--channels"});
}

TEST(Arguments, Models) {
    expect_refused({"run", "slider-crnk"}, {"'slider-crnk'", "did you mean 'slider-crank'?"});
    expect_refused({"check", "missing.json"},
                   {"'missing.json'", "neither a file nor a ready mechanism", "pendulum"});
    expect_refused({"export", "pendulums"}, {"did you mean 'pendulum'?"});
    expect_refused({"run", "chain", "--param", "links"}, {"--param", "'links'", "name=value"});
    expect_refused({"run", "chain", "--param", "links="}, {"--param", "'links='"});
    expect_refused({"run", "chain", "--param", "links=2", "--param", "links=3"}, {"'links'", "twice"});
    expect_refused({"run", "chain", "--param", "links=0"},
                   {"chain: /parameters/links: ", "0", "; allowed: "});
    expect_refused({"run", "chain", "--param", "joint=glue"}, {"/parameters/joint", "glue", "spherical"});
    expect_refused({"run", "chain", "--param", "link=3"}, {"/parameters/link", "links"});
}

TEST(Arguments, EverythingIsRead) {
    const Arguments a = parse_arguments(
        {"run",      "--param",       "a=1",          "model.json",  "--param", "b=x=y",   "--integrator",
         "rk4",      "--formulation", "saddle-point", "--rtol",      "1e-7",    "--atol",  "1e-9",
         "--step",   "1e-4",          "--end",        "2",           "--every", "0.5",     "--channels",
         "a.*,b.f?", "--channels",    "energy.*",     "--threads",   "2",       "--start", "as-given",
         "--out",    "here",          "--quiet",      "--max-order", "3"});
    ASSERT_EQ(a.command, Arguments::Command::run);
    EXPECT_EQ(a.run.model.model, "model.json");
    EXPECT_EQ(a.run.model.parameters, (std::map<std::string, std::string>{{"a", "1"}, {"b", "x=y"}}));
    EXPECT_EQ(a.run.integrator, "rk4");
    EXPECT_EQ(a.run.formulation, "saddle-point");
    EXPECT_EQ(a.run.rtol, 1e-7);
    EXPECT_EQ(a.run.atol, 1e-9);
    EXPECT_EQ(a.run.step, 1e-4);
    EXPECT_EQ(a.run.end, 2.0);
    EXPECT_EQ(a.run.every, 0.5);
    EXPECT_EQ(a.run.channels, (Words{"a.*", "b.f?", "energy.*"}));
    EXPECT_EQ(a.run.threads, 2);
    EXPECT_EQ(a.run.max_order, 3);
    EXPECT_EQ(a.run.out, "here");
    EXPECT_TRUE(a.run.quiet);
}

TEST(Arguments, HelpAndVersion) {
    const Outcome version = command({"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_EQ(version.out, "gudgeon " GUDGEON_VERSION "\n");
    const Outcome help = command({"--help"});
    EXPECT_EQ(help.code, 0);
    for (const char* word : {"run", "check", "list", "export", "--version"})
        EXPECT_NE(help.out.find(word), std::string::npos) << help.out;
    const Outcome run = command({"run", "--help"});
    EXPECT_EQ(run.code, 0);
    for (const char* word :
         {"--param", "--integrator", "--formulation", "--rtol", "--atol", "--step", "--end", "--every",
          "--channels", "--threads", "--start", "--out", "--quiet", "--max-order"})
        EXPECT_NE(run.out.find(word), std::string::npos) << run.out;
}

} // namespace
} // namespace gudgeon
