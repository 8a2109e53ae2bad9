// What a step is made of, by group: timed by gudgeon_bench, counted by gudgeon_regression.
#pragma once

#include "counted.hpp"

namespace gudgeon::kernels {

struct Setup {
    int bodies = 0; // about; kernels of one size do not look at it
    int threads = 1;
    bool rewind = true; // steps: ten at a time, always the same; else one after the other
};

struct Kernel {
    std::string name; // group/what
    std::function<counted::Work(const Setup&)> prepare;
    int bodies;            // that are counted; 0: of one size
    int per_item = 1;      // bodies per item; of one size: items
    bool threaded = false; // takes part of its work to several threads
};
using Kernels = std::vector<Kernel>;

Kernels joint_kernels();   // every kind of perfect joint, drives
Kernels force_kernels();   // springs, tyres
Kernels contact_kernels(); // bushings, strips, balls, slots
Kernels law_kernels();     // normal laws, friction laws
Kernels system_kernels();  // residual, derivatives, matrix, accelerations
Kernels solver_kernels();  // factorisations, solutions
Kernels step_kernels();    // steps of the integrators
Kernels all_kernels();

} // namespace gudgeon::kernels
