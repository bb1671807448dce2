// Many fits on a pool of threads, each with one fitter that it uses again and again: 05_thread_pool FOLDER FITS
//
// All fitters use one frame, of which nothing is copied.
//
// The fits differ by errors of half a pixel that are added to the edges: how much does the radius move?
#include "frame.hpp"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <thread>

int main(int argc, char **argv)
try {
    if (argc != 3 || std::atoi(argv[2]) < 2) {
        std::fprintf(stderr, "usage: %s FOLDER FITS, at least 2\n", argv[0]);
        return 2;
    }
    const Frame frame(argv[1]);
    cylfuse::Frame shared;
    shared.set_intrinsics(frame.camera);
    shared.set_depth(frame.depth_view());
    std::vector<double> radius(static_cast<std::size_t>(std::atoi(argv[2])));
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::atomic<bool> failed{false};

    const auto work = [&] {
        try {
            cylfuse::Fitter fitter;
            for (std::size_t job; !failed && (job = next++) < radius.size();) {
                // Seeded by the job: the same results whichever thread takes it.
                std::mt19937 random(static_cast<std::mt19937::result_type>(job));
                std::normal_distribution<double> error(0.0, 0.5);
                std::vector<std::array<double, 4>> edges = frame.edges;
                for (auto &edge : edges) {
                    for (double &coordinate : edge) {
                        coordinate += error(random);
                    }
                }
                fitter.clear();
                fitter.use_frame(shared, frame.mask_view());
                fitter.push_edges(edges);
                radius[job] = fitter.fit().cylinder.model.radius;
            }
        } catch (...) {
            if (!failed.exchange(true)) {
                failure = std::current_exception();
            }
        }
    };
    std::vector<std::thread> pool;
    for (unsigned k = 0; k < std::max(1U, std::thread::hardware_concurrency()); ++k) {
        pool.emplace_back(work);
    }
    for (std::thread &thread : pool) {
        thread.join();
    }
    if (failure) {
        std::rethrow_exception(failure);
    }

    double mean = 0.0, square = 0.0;
    for (const double value : radius) {
        mean += value / double(radius.size());
    }
    for (const double value : radius) {
        square += (value - mean) * (value - mean) / double(radius.size() - 1);
    }
    std::printf("%zu fits: radius %.2f mm, standard deviation %.3f mm\n", radius.size(), 1e3 * mean,
                1e3 * std::sqrt(square));
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
