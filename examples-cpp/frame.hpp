// Reads a frame without other libraries: camera.txt, depth.pgm, mask.pgm, image.pgm and edges.txt of one folder.
#ifndef FRAME_HPP
#define FRAME_HPP

#include <cylfuse/cylfuse.hpp>

#include <fstream>
#include <stdexcept>
#include <string>

struct Frame {
    cylfuse::Intrinsics camera;
    double depth_unit; // metres per unit of the depth image
    std::vector<std::uint16_t> depth;
    std::vector<std::uint8_t> mask;
    std::vector<std::uint8_t> image; // grey, linear in light
    std::vector<std::array<double, 4>> edges; // x1 y1 x2 y2

    explicit Frame(const std::string &folder)
    {
        std::ifstream camera_file(folder + "/camera.txt");
        camera_file >> camera.width >> camera.height >> camera.fx >> camera.fy >> camera.cx >> camera.cy >> depth_unit;
        check(camera_file, folder + "/camera.txt");
        const std::vector<std::uint8_t> bytes = read_pgm(folder + "/depth.pgm", 65535);
        for (std::size_t k = 0; k < bytes.size(); k += 2) {
            depth.push_back(static_cast<std::uint16_t>(bytes[k] << 8 | bytes[k + 1])); // PGM is big-endian.
        }
        mask = read_pgm(folder + "/mask.pgm", 255);
        image = read_pgm(folder + "/image.pgm", 255);
        std::ifstream edges_file(folder + "/edges.txt");
        for (std::array<double, 4> edge; edges_file >> edge[0] >> edge[1] >> edge[2] >> edge[3];) {
            edges.push_back(edge);
        }
    }

    cylfuse::DepthView depth_view() const { return {depth.data(), camera.width, camera.height, depth_unit}; }
    cylfuse::MaskView mask_view() const { return {mask.data(), camera.width, camera.height}; }
    cylfuse::ImageView image_view() const { return {image.data(), camera.width, camera.height}; }

private:
    static void check(const std::istream &file, const std::string &path)
    {
        if (!file) {
            throw std::runtime_error(path + " cannot be read");
        }
    }

    std::vector<std::uint8_t> read_pgm(const std::string &path, unsigned maximum) const
    {
        std::ifstream file(path, std::ios::binary);
        std::string kind;
        std::uint32_t width = 0, height = 0;
        unsigned most = 0;
        file >> kind >> width >> height >> most;
        file.get();
        check(file, path);
        if (kind != "P5" || width != camera.width || height != camera.height || most != maximum) {
            throw std::runtime_error(path + " is no binary PGM of the size of the camera");
        }
        std::vector<std::uint8_t> bytes(std::size_t(width) * height * (maximum > 255 ? 2 : 1));
        file.read(reinterpret_cast<char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        check(file, path);
        return bytes;
    }
};

#endif
