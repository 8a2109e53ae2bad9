// The ready mechanisms with what their runs are compared with.
//
// Three kinds of references: closed forms and single ordinary differential equations (exact); tables
// computed elsewhere without this program (independent); and where there are none, two runs of this
// program by methods that share nothing but the equations of motion (converged). Of these the one judges
// that was made by another method than the run, and their difference tells how far both are believed.
#pragma once

#include "core/model.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace gudgeon::work_precision {

/// How one of two converged references is made.
struct Making {
    std::string integrator; // rk4, gear, radau, ida
    double rtol = 0;        // or, of rk4:
    double step = 0;        // s; whole numbers of it between the times of comparison
};

/// The compared channels at the compared times.
struct Solution {
    std::string made_by;                     // an integrator; empty: not by this program
    std::vector<std::vector<double>> values; // [channel][time]
};

struct Problem {
    std::string mechanism; // as in the tables: the ready mechanism's name and what is not its default
    int size = 1;          // links, loops, units
    std::string base;      // the ready mechanism's name
    std::map<std::string, std::string> parameters;
    double end = 0;                    // s
    std::vector<std::string> channels; // compared, m (stops: also rad)
    double rk4_step = 1e-2;            // s, the longest tried; then halves of it
    double bayo_step = 1e-2;
    std::vector<Making> makings; // two where converged, else empty

    std::string reference;     // what it is, for the reader
    double believed = 0;       // largest error of the reference (m), as far as known
    std::vector<double> times; // of the comparison, s
    std::vector<Solution> solutions;

    /// mechanism and size in one word, for file names and --problems
    std::string id() const;
    Model model() const;
    /// What judges runs of this integrator: not made by the same method. Throws std::logic_error where
    /// there is none.
    const Solution& solution_for(const std::string& integrator) const;
};

/// All, without references.
std::vector<Problem> list_problems();

/// Fills in times, solutions, believed and reference. tables: tests/data/reference; data: bench/data.
/// Throws std::runtime_error for a missing or unfit table.
void load_reference(Problem& problem, const std::filesystem::path& tables, const std::filesystem::path& data);

/// bench/data/<id>.<integrator>.csv
std::filesystem::path data_file(const Problem& problem, const Making& making,
                                const std::filesystem::path& data);

/// Problems up to this size whose id fits one of the globs; where there are none, all of them.
std::vector<Problem> chosen_problems(const std::vector<std::string>& globs, int largest);

/// Angles at these times (s, rising), rad, by classical Runge-Kutta steps of `step` in long double.
/// Pendulum below the horizontal: a'' = g cos a from rest at 0. Cranks of the four-bar chain:
/// a'' = g (9 N + 3) / (8 N + 2) sin a, a(0) = 0, a'(0) = 1.
std::vector<double> pendulum_angle(const std::vector<double>& times, double step);
std::vector<double> four_bar_angle(int loops, const std::vector<double>& times, double step);

} // namespace gudgeon::work_precision
