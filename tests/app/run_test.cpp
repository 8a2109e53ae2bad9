// Runs through the command: exit codes, files, output times, what a failed or interrupted run leaves.
#include "app/command_tools.hpp"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include <fcntl.h>
#include <sys/wait.h>

namespace gudgeon {
namespace {

using nlohmann::json;
using test::command;
using test::Csv;
using test::Outcome;
using test::read_csv;
using test::summary_in;
using test::text_of;

namespace fs = std::filesystem;

class Run : public test::CommandTest {};

TEST_F(Run, ThrownStoneAgainstItsParabola) {
    const std::string model = write("stone.json", test::free_body);
    const Outcome outcome = command({"run", model, "--end", "1", "--every", "0.3", "--out", path("out")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_NE(outcome.out.find("thrown"), std::string::npos) << outcome.out;
    const Csv csv = read_csv(folder_ / "out/trajectory.csv");
    EXPECT_EQ(csv.names.front(), "t");
    EXPECT_EQ(csv.names.size(), 1u + 19 + 6);
    ASSERT_EQ(csv.rows.size(), 5u);
    const std::array<double, 5> times{0, 0.3, 2 * 0.3, 3 * 0.3, 1};
    for (std::size_t k = 0; k < 5; ++k) {
        const double t = times[k];
        EXPECT_EQ(csv.rows[k][0], t);
        EXPECT_NEAR(csv.rows[k][csv.column("stone.x")], 0.5 * t, 1e-6);
        EXPECT_NEAR(csv.rows[k][csv.column("stone.z")], 3 * t - 9.81 / 2 * t * t, 1e-5);
        EXPECT_NEAR(csv.rows[k][csv.column("stone.vz")], 3 - 9.81 * t, 1e-5);
        EXPECT_NEAR(csv.rows[k][csv.column("stone.az")], -9.81, 1e-12);
        EXPECT_EQ(csv.rows[k][csv.column("stone.e0")], 1.0);
        EXPECT_NEAR(csv.rows[k][csv.column("energy.kinetic")] + csv.rows[k][csv.column("energy.potential")],
                    9.25, 1e-3);
    }
    EXPECT_EQ(csv.words[1][0], "0.29999999999999999"); // 17 digits
}

TEST_F(Run, SummaryHasEveryKey) {
    const std::string model = write("stone.json", test::free_body);
    ASSERT_EQ(command({"run", model, "--param", "m=4", "--rtol", "1e-7", "--end", "0.5", "--out", path("out"),
                       "--channels", "stone.?"})
                  .code,
              0);
    const json s = summary_in(folder_ / "out");
    for (const char* key : {"model",
                            "parameters",
                            "integrator",
                            "formulation",
                            "linear_solver",
                            "rtol",
                            "atol",
                            "threads",
                            "end",
                            "reached",
                            "status",
                            "reason",
                            "bodies",
                            "unknowns",
                            "dof",
                            "redundant",
                            "steps",
                            "rejected_error",
                            "rejected_newton",
                            "rejected_contact",
                            "newton_sweeps",
                            "factorisations",
                            "refactorisations",
                            "cholmod_factorisations",
                            "cholmod_solves",
                            "cholmod_iterations",
                            "klu_fallbacks",
                            "order_histogram",
                            "cpu_seconds",
                            "cpu_seconds_by_phase",
                            "nnz_matrix",
                            "nnz_factors",
                            "constraint_position_max",
                            "constraint_velocity_max",
                            "energy_balance_max",
                            "contacts",
                            "wall_seconds",
                            "settings",
                            "assembly"})
        EXPECT_TRUE(s.contains(key)) << key;
    EXPECT_EQ(s["model"], "thrown");
    EXPECT_EQ(s["parameters"]["m"], 4.0);
    EXPECT_EQ(s["parameters"]["up"], 3.0);
    EXPECT_EQ(s["integrator"], "auto");
    EXPECT_EQ(s["integrators_used"][0]["integrator"], "erk"); // a free body: nothing stiff
    EXPECT_EQ(s["rtol"], 1e-7);
    EXPECT_EQ(s["atol"], 1e-7); // as rtol
    EXPECT_EQ(s["status"], "ok");
    EXPECT_EQ(s["reason"], "");
    EXPECT_EQ(s["end"], 0.5);
    EXPECT_EQ(s["reached"], 0.5);
    EXPECT_EQ(s["bodies"], 1);
    EXPECT_EQ(s["dof"], 6);
    EXPECT_EQ(s["redundant"], 0);
    EXPECT_EQ(s["unknowns"], 6);
    EXPECT_EQ(s["samples"], 101);
    EXPECT_EQ(s["columns"], 3);
    EXPECT_TRUE(s["contacts"].is_object());
    EXPECT_EQ(s["settings"]["given"]["--rtol"], "1e-7");
    EXPECT_EQ(s["settings"]["used"]["integrator"], "auto");
    long steps = 0;
    for (const json& count : s["order_histogram"])
        steps += count.get<long>();
    EXPECT_EQ(steps, s["steps"].get<long>());
    const json& phases = s["cpu_seconds_by_phase"];
    double sum = 0;
    for (const char* phase :
         {"evaluate", "assemble", "factor", "solve", "control", "contact", "output", "other"})
        sum += phases.at(phase).get<double>();
    EXPECT_TRUE(phases.contains("setup"));
    EXPECT_NEAR(sum, s["cpu_seconds"].get<double>(), 0.05 * sum + 1e-9);
}

TEST_F(Run, ContactsInSummaryColumnsAndTheirOwnFile) {
    ASSERT_EQ(command({"run", "bouncing-journal", "--end", "0.1", "--contacts", "--out", path("c")}).code, 0);
    const json contact = summary_in(folder_ / "c")["contacts"]["bearing"];
    EXPECT_EQ(contact["impacts"], 24); // three contacts of eight strips
    EXPECT_NEAR(contact["deepest"].get<double>(), 5.15e-4, 1e-6);
    EXPECT_NEAR(contact["peak_force"].get<double>(), 61.0, 1.0);
    EXPECT_GT(contact["share"].get<double>(), 0.2);
    EXPECT_LT(contact["share"].get<double>(), 0.8);
    EXPECT_GT(contact["energy_lost"].get<double>(), 1e-3);
    const Csv trajectory = read_csv(folder_ / "c" / "trajectory.csv");
    for (const char* column : {"penetration", "normal_force", "friction_force", "strips", "dissipated"})
        EXPECT_NE(std::ranges::find(trajectory.names, "bearing." + std::string(column)),
                  trajectory.names.end())
            << column;
    const std::string events = text_of(folder_ / "c" / "contacts.csv");
    EXPECT_TRUE(events.starts_with("t,depth,speed,event,joint,contact\n")) << events.substr(0, 80);
    EXPECT_NE(events.find("start,bearing,strip 1\n"), std::string::npos);
    EXPECT_NE(events.find("end,bearing,strip 8\n"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder_ / "c" / "steps.csv"));
}

TEST_F(Run, ReadyMechanismWithItsDefaults) {
    ASSERT_EQ(command({"run", "slider-crank", "--end", "0.1", "--out", path("a")}).code, 0);
    const json s = summary_in(folder_ / "a");
    EXPECT_EQ(s["model"], "slider-crank");
    EXPECT_EQ(s["bodies"], 3);
    EXPECT_EQ(s["dof"], 1);
    EXPECT_EQ(s["unknowns"], 18 + 17);
    EXPECT_LT(s["constraint_position_max"].get<double>(), 1e-10);
    EXPECT_LT(s["constraint_velocity_max"].get<double>(), 1e-10);
    EXPECT_LT(s["energy_balance_max"].get<double>(), 1e-4);
    const Csv csv = read_csv(folder_ / "a/trajectory.csv");
    EXPECT_EQ(csv.rows.front()[csv.column("slider.x")], 0.2);
    ASSERT_EQ(command({"run", "chain", "--param", "joint=spherical", "--param", "links=2", "--end", "0.01",
                       "--out", path("b")})
                  .code,
              0);
    EXPECT_EQ(summary_in(folder_ / "b")["parameters"],
              (json{{"joint", "spherical"}, {"links", 2.0}, {"thin", 0.0}}));
}

TEST_F(Run, EveryIntegratorGivesTheSameTrajectory) {
    std::vector<Csv> all;
    for (const char* integrator : {"auto", "gear", "radau", "ida", "rk4", "bayo"}) {
        const Outcome outcome =
            command({"run", "pendulum", "--integrator", integrator, "--rtol", "1e-8", "--end", "0.5",
                     "--every", "0.1", "--out", path(integrator), "--quiet"});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.out + outcome.err, "");
        EXPECT_EQ(summary_in(folder_ / integrator)["integrator"], integrator);
        all.push_back(read_csv(folder_ / integrator / "trajectory.csv"));
        ASSERT_EQ(all.back().rows.size(), 6u);
    }
    const std::size_t z = all[0].column("bob.z");
    for (std::size_t k = 0; k < 6; ++k) {
        EXPECT_NEAR(all[0].rows[k][z], all[2].rows[k][z], 1e-6);
        EXPECT_NEAR(all[1].rows[k][z], all[2].rows[k][z], 1e-5);
    }
}

TEST_F(Run, FormulationsAreToldAndCounted) {
    for (const std::string word : {"saddle-point", "saddle-point-klu", "augmented-lagrangian", "auto"}) {
        const Outcome outcome = command({"run", "chain", "--integrator", "radau", "--formulation", word,
                                         "--end", "0.2", "--every", "0.1", "--out", path(word), "--quiet"});
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        const json s = summary_in(folder_ / word);
        const bool cholmod = word == "augmented-lagrangian";
        EXPECT_EQ(s["formulation"], word == "auto" ? "saddle-point" : word);
        EXPECT_EQ(s["linear_solver"], cholmod ? "cholmod" : word == "saddle-point-klu" ? "klu" : "block");
        EXPECT_EQ(s["settings"]["used"]["formulation"], word);
        EXPECT_EQ(s["cholmod_solves"] > 0, cholmod);
        EXPECT_EQ(s["cholmod_factorisations"] > 0, cholmod);
        EXPECT_EQ(s["cholmod_iterations"] > 0, cholmod);
        EXPECT_EQ(s["klu_fallbacks"], 0);
    }
}

struct H5 {
    explicit H5(const fs::path& file) : id(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {}
    ~H5() { H5Fclose(id); }
    H5(const H5&) = delete;
    H5& operator=(const H5&) = delete;

    std::vector<hsize_t> size(const char* name) const {
        const hid_t set = H5Dopen2(id, name, H5P_DEFAULT), space = H5Dget_space(set);
        std::vector<hsize_t> dims(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
        H5Sget_simple_extent_dims(space, dims.data(), nullptr);
        H5Sclose(space);
        H5Dclose(set);
        return dims;
    }
    std::vector<double> numbers(const char* name) const {
        hsize_t count = 1;
        for (const hsize_t n : size(name))
            count *= n;
        std::vector<double> out(count);
        const hid_t set = H5Dopen2(id, name, H5P_DEFAULT);
        EXPECT_GE(H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out.data()), 0);
        H5Dclose(set);
        return out;
    }
    std::vector<std::string> texts(const char* name) const {
        std::vector<char*> raw(size(name).at(0));
        const hid_t set = H5Dopen2(id, name, H5P_DEFAULT), type = H5Dget_type(set), space = H5Dget_space(set);
        EXPECT_GE(H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data()), 0);
        std::vector<std::string> out(raw.begin(), raw.end());
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, raw.data());
        H5Sclose(space);
        H5Tclose(type);
        H5Dclose(set);
        return out;
    }
    std::string text_attribute(const char* name) const {
        const hid_t attribute = H5Aopen(id, name, H5P_DEFAULT), type = H5Aget_type(attribute);
        char* raw = nullptr;
        EXPECT_GE(H5Aread(attribute, type, &raw), 0);
        const std::string out = raw ? raw : "";
        H5free_memory(raw);
        H5Tclose(type);
        H5Aclose(attribute);
        return out;
    }
    double number_attribute(const char* name) const {
        const hid_t attribute = H5Aopen(id, name, H5P_DEFAULT);
        double out = 0;
        EXPECT_GE(H5Aread(attribute, H5T_NATIVE_DOUBLE, &out), 0);
        H5Aclose(attribute);
        return out;
    }
    hid_t id;
};

TEST_F(Run, Hdf5HoldsWhatTheCsvHolds) {
    // More output times than one block of rows.
    ASSERT_EQ(command({"run", "pendulum", "--end", "2", "--every", "1e-3", "--channels", "bob.?,rod.f?",
                       "--out", path("out")})
                  .code,
              0);
    const Csv csv = read_csv(folder_ / "out/trajectory.csv");
    const H5 file(folder_ / "out/trajectory.h5");
    ASSERT_GE(file.id, 0);
    EXPECT_EQ(csv.names,
              (std::vector<std::string>{"t", "bob.x", "bob.y", "bob.z", "rod.fx", "rod.fy", "rod.fz"}));
    EXPECT_EQ(file.texts("names"), std::vector<std::string>(csv.names.begin() + 1, csv.names.end()));
    EXPECT_EQ(file.texts("units"), (std::vector<std::string>{"m", "m", "m", "N", "N", "N"}));
    ASSERT_EQ(csv.rows.size(), 2001u);
    EXPECT_EQ(file.size("t"), std::vector<hsize_t>{2001});
    EXPECT_EQ(file.size("values"), (std::vector<hsize_t>{2001, 6}));
    const std::vector<double> t = file.numbers("t"), values = file.numbers("values");
    for (std::size_t k = 0; k < csv.rows.size(); ++k) {
        ASSERT_EQ(t[k], csv.rows[k][0]);
        for (std::size_t i = 0; i < 6; ++i)
            ASSERT_EQ(values[6 * k + i], csv.rows[k][i + 1]) << k << ' ' << csv.names[i + 1];
    }
    EXPECT_EQ(file.text_attribute("model"), "pendulum");
    EXPECT_EQ(file.text_attribute("integrator"), "auto");
    EXPECT_EQ(file.text_attribute("parameters"), "{}");
    EXPECT_EQ(file.text_attribute("status"), "ok");
    EXPECT_EQ(file.text_attribute("version"), GUDGEON_VERSION);
    EXPECT_EQ(file.number_attribute("rtol"), 1e-6);
}

TEST_F(Run, ReplacesItsOwnFilesAndNothingElse) {
    const std::string model = write("stone.json", test::free_body);
    fs::create_directory(folder_ / "out");
    write("out/notes.txt", "mine");
    write("out/trajectory.csv", "old");
    write("out/summary.json", "old");
    ASSERT_EQ(command({"run", model, "--end", "0.1", "--out", path("out")}).code, 0);
    EXPECT_EQ(text_of(folder_ / "out/notes.txt"), "mine");
    EXPECT_EQ(summary_in(folder_ / "out")["status"], "ok");
    EXPECT_EQ(read_csv(folder_ / "out/trajectory.csv").rows.size(), 101u);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), fs::directory_iterator{}), 4);
    // A refused run leaves the earlier results alone.
    EXPECT_EQ(command({"run", model, "--channels", "stne.x", "--out", path("out")}).code, 2);
    EXPECT_EQ(read_csv(folder_ / "out/trajectory.csv").rows.size(), 101u);
}

TEST_F(Run, FolderThatCannotBeWritten) {
    const std::string model = write("stone.json", test::free_body);
    write("file", "no folder");
    for (const char* out : {"file", "file/below", "file/far/below"}) {
        const Outcome outcome = command({"run", model, "--out", path(out)});
        EXPECT_EQ(outcome.code, 5) << out;
        EXPECT_NE(outcome.err.find(path(out) + ": "), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(text_of(folder_ / "file"), "no folder");
    fs::create_directories(folder_ / "out/trajectory.h5");
    EXPECT_EQ(command({"run", model, "--out", path("out")}).code, 5);
    EXPECT_TRUE(fs::is_directory(folder_ / "out/trajectory.h5"));
    // A folder in place of the model.
    EXPECT_EQ(command({"run", path("out"), "--out", path("other")}).code, 5);
}

TEST_F(Run, GlobThatMatchesNothing) {
    const Outcome outcome = command({"run", "pendulum", "--channels", "bob.x,rdo.fx", "--out", path("out")});
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("'rdo.fx'"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("did you mean 'rod'?"), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Run, TooManyColumnsAskForAChoice) {
    // 70 links: 19 columns each, 13 per revolute joint, 6 of the marker, 6 energies.
    const Outcome outcome = command({"run", "chain", "--param", "links=70", "--out", path("out")});
    EXPECT_EQ(outcome.code, 2);
    for (const char* word : {"--channels", "2252", "2000", "'link1.*'", "'J1.f?'", "'energy.*'"})
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err << word;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
    EXPECT_EQ(command({"run", "chain", "--param", "links=70", "--end", "0.001", "--channels", "*", "--out",
                       path("out")})
                  .code,
              0);
    EXPECT_EQ(read_csv(folder_ / "out/trajectory.csv").names.size(), 2253u);
}

TEST_F(Run, FailedIntegrationLeavesWhatItComputed) {
    const std::string model = write("locking.json", test::locking);
    const Outcome outcome = command({"run", model, "--end", "3", "--every", "0.1", "--out", path("out")});
    EXPECT_EQ(outcome.code, 4) << outcome.out;
    EXPECT_EQ(outcome.err.find(model + ": "), 0u) << outcome.err;
    const json s = summary_in(folder_ / "out");
    EXPECT_EQ(s["status"], "failed");
    EXPECT_NE(s["reason"], "");
    EXPECT_NE(outcome.err.find(s["reason"].get<std::string>()), std::string::npos) << outcome.err;
    const double reached = s["reached"].get<double>();
    EXPECT_GT(reached, 1.3);
    EXPECT_LT(reached, 1.51);
    const Csv csv = read_csv(folder_ / "out/trajectory.csv");
    ASSERT_EQ(csv.rows.size(), static_cast<std::size_t>(std::floor(reached / 0.1)) + 1);
    EXPECT_EQ(csv.rows.size(), s["samples"]);
    for (const auto& row : csv.rows)
        EXPECT_NEAR(row[csv.column("cart.x")], 0.5 + row[0], 1e-9);
    const H5 file(folder_ / "out/trajectory.h5");
    EXPECT_EQ(file.size("t").at(0), csv.rows.size());
    EXPECT_EQ(file.text_attribute("status"), "failed");
}

TEST_F(Run, StartIsAssembledAndSaidSo) {
    // The stone hangs 1 mm too low on a rod of 1 m.
    const std::string model = write("hanging.json", R"({"gudgeon": 1, "name": "hanging",
        "bodies": [{"name": "stone", "mass": 1, "inertia": [1, 1, 1], "position": [0, 0, -1.001]}],
        "joints": [{"name": "rod", "kind": "distance", "bodies": ["ground", "stone"], "points": [[0, 0, 0], [0, 0, -1.001]], "length": 1}]})");
    const Outcome outcome = command({"run", model, "--end", "0.01", "--out", path("out")});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("assembled"), std::string::npos) << outcome.out;
    EXPECT_NE(outcome.out.find("stone: moved 0.001 m"), std::string::npos) << outcome.out;
    const json assembly = summary_in(folder_ / "out")["assembly"];
    EXPECT_NEAR(assembly["position_before"].get<double>(), 1e-3, 1e-12);
    EXPECT_LT(assembly["position_after"].get<double>(), 1e-12);
    EXPECT_NEAR(assembly["changes"]["stone"]["shift"].get<double>(), 1e-3, 1e-12);
    EXPECT_EQ(command({"run", "pendulum", "--end", "0.01", "--out", path("out")}).out.find("assembled"),
              std::string::npos);
}

TEST_F(Run, MechanismThatCannotClose) {
    const std::string model = write("open.json", R"({"gudgeon": 1,
        "bodies": [{"name": "stone", "mass": 1, "inertia": [1, 1, 1], "position": [1, 0, 0]}],
        "joints": [{"name": "here", "kind": "distance", "bodies": ["ground", "stone"], "points": [[0, 0, 0], [1, 0, 0]], "length": 1},
                   {"name": "there", "kind": "distance", "bodies": ["ground", "stone"], "points": [[5, 0, 0], [1, 0, 0]], "length": 1}]})");
    const Outcome outcome = command({"run", model, "--out", path("out")});
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.err.find(model + ": "), 0u) << outcome.err;
    EXPECT_NE(outcome.err.find("'here'"), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Run, ProgressOnTerminalsOnly) {
    const std::vector<std::string> args{"run",     "chain", "--end", "1",
                                        "--every", "0.001", "--out", path("out")};
    EXPECT_EQ(command(args, false).err, "");
    std::vector<std::string> quiet = args;
    quiet.push_back("--quiet");
    EXPECT_EQ(command(quiet, true).err, "");
    const std::string bar = command(args, true).err;
    EXPECT_TRUE(bar.empty() || bar.find(" of 1 s") != std::string::npos) << bar; // empty: a fast machine
}

pid_t start(const std::vector<std::string>& args, const fs::path& folder) {
    const pid_t child = fork();
    if (child != 0)
        return child;
    std::vector<std::string> words{GUDGEON_EXE};
    words.insert(words.end(), args.begin(), args.end());
    std::vector<char*> raw;
    for (std::string& word : words)
        raw.push_back(word.data());
    raw.push_back(nullptr);
    const int log = open((folder / "log.txt").c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    if (chdir(folder.c_str()) != 0)
        _exit(99);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execv(GUDGEON_EXE, raw.data());
    _exit(99);
}

int exit_code(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

TEST_F(Run, InterruptWritesWhatWasComputed) {
    for (const int signal : {SIGINT, SIGTERM}) {
        const fs::path csv_file = folder_ / "out/trajectory.csv";
        fs::remove(csv_file);
        const pid_t child =
            start({"run", "chain", "--param", "links=4", "--end", "1e6", "--every", "0.01", "--out", "out"},
                  folder_);
        ASSERT_GT(child, 0);
        for (int i = 0; i < 2000 && !(fs::exists(csv_file) && fs::file_size(csv_file) > 100000); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        kill(child, signal);
        EXPECT_EQ(exit_code(child), 130) << text_of(folder_ / "log.txt");
        const json s = summary_in(folder_ / "out");
        EXPECT_EQ(s["status"], "interrupted");
        EXPECT_NE(s["reason"], "");
        EXPECT_LT(s["reached"].get<double>(), 1e6);
        const Csv csv = read_csv(csv_file);
        EXPECT_GT(csv.rows.size(), 10u);
        EXPECT_EQ(csv.rows.size(), s["samples"]);
        EXPECT_LE(csv.rows.back()[0], s["reached"].get<double>());
        EXPECT_EQ(H5(folder_ / "out/trajectory.h5").size("t").at(0), csv.rows.size());
    }
}

TEST_F(Run, ExecutableWithDefaultFolderTwice) {
    // The second time ./pendulum exists and must not be taken for the model.
    for (int i = 0; i < 2; ++i)
        EXPECT_EQ(exit_code(start({"run", "pendulum", "--end", "0.1"}, folder_)), 0)
            << text_of(folder_ / "log.txt");
    EXPECT_EQ(summary_in(folder_ / "pendulum")["status"], "ok");
    EXPECT_EQ(exit_code(start({"run", "pendulum", "--rtol", "no"}, folder_)), 2);
    EXPECT_EQ(exit_code(start({"--version"}, folder_)), 0);
    EXPECT_NE(text_of(folder_ / "log.txt").find("gudgeon " GUDGEON_VERSION), std::string::npos);
}

TEST_F(Run, ThreadsDoNotChangeTheResults) {
    std::vector<std::string> texts;
    for (const char* threads : {"1", "2"}) {
        ASSERT_EQ(command({"run", "suspension-chain", "--param", "units=2", "--end", "0.2", "--threads",
                           threads, "--out", path(threads)})
                      .code,
                  0);
        texts.push_back(text_of(folder_ / threads / "trajectory.csv"));
        EXPECT_EQ(summary_in(folder_ / threads)["threads"], std::stoi(threads));
    }
    EXPECT_EQ(texts[0], texts[1]);
}

} // namespace
} // namespace gudgeon
