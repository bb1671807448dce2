/* A cylinder of radius 0.05 and length 0.2, 0.7 in front of a pinhole, seen obliquely. */
#include "check.h"

scene the_scene;

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3])
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* out = a + s b */
static void add(const double a[3], double s, const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) {
        out[k] = a[k] + s * b[k];
    }
}

static const double HALF_LENGTH = 0.1;

/* Rays by which a pixel of the image is averaged, in each direction. */
enum { RAYS = 8 };

/* The frame across the axis: the unit vector from the origin to the axis, and the one to its side. */
static void across_axis(double toward[3], double sideways[3], double *distance)
{
    const double *d = the_scene.truth.direction;
    double nearest[3];
    add(the_scene.truth.point, -dot(the_scene.truth.point, d), d, nearest);
    *distance = sqrt(dot(nearest, nearest));
    add(nearest, 1.0 / *distance - 1.0, nearest, toward);
    cross(d, toward, sideways);
}

static void make_points(void)
{
    double toward[3], sideways[3], distance;
    across_axis(toward, sideways, &distance);
    for (int row = 0; row < ROWS; row++) {
        double angle = (2.0 * row / (ROWS - 1) - 1.0) * 1.1;
        for (int column = 0; column < COLUMNS; column++) {
            double along = (2.0 * column / (COLUMNS - 1) - 1.0) * HALF_LENGTH;
            double *p = the_scene.points[row * COLUMNS + column];
            add(the_scene.truth.point, along, the_scene.truth.direction, p);
            add(p, -the_scene.truth.radius * cos(angle), toward, p);
            add(p, the_scene.truth.radius * sin(angle), sideways, p);
        }
    }
}

/* The depth at which the ray of a pixel meets the near wall between the ends; 0 when it does not. */
static double near_wall(double column, double row)
{
    const cylfuse_cylinder *model = &the_scene.truth;
    const cylfuse_intrinsics *camera = &the_scene.intrinsics;
    double ray[3] = {(column - camera->cx) / camera->fx, (row - camera->cy) / camera->fy, 1.0};
    double k[3], w[3];
    add(ray, -dot(ray, model->direction), model->direction, k);
    add(model->point, -dot(model->point, model->direction), model->direction, w);
    /* |t k - w| = r */
    double a = dot(k, k), b = dot(k, w), c = dot(w, w) - model->radius * model->radius;
    if (b * b < a * c) {
        return 0.0;
    }
    double t = (b - sqrt(b * b - a * c)) / a;
    double along = t * dot(ray, model->direction) - dot(model->point, model->direction);
    return fabs(along) <= HALF_LENGTH ? t : 0.0;
}

static void make_images(void)
{
    for (int row = 0; row < HEIGHT; row++) {
        for (int column = 0; column < WIDTH; column++) {
            double z = near_wall(column, row);
            the_scene.depth[row * WIDTH + column] = (float)(z > 0.0 ? z : 2.0);
            the_scene.mask[row * WIDTH + column] = z > 0.0 ? 255 : 0;
            the_scene.mask_pixels += z > 0.0;
            int inside = 0;
            for (int ray = 0; ray < RAYS * RAYS; ray++) {
                double across = (ray % RAYS + 0.5) / RAYS - 0.5, down = (ray / RAYS + 0.5) / RAYS - 0.5;
                inside += near_wall(column + across, row + down) > 0.0;
            }
            the_scene.image[row * WIDTH + column] = (float)(40.0 + 160.0 * inside / (RAYS * RAYS));
        }
    }
}

static void make_edges(void)
{
    const cylfuse_intrinsics *camera = &the_scene.intrinsics;
    double toward[3], sideways[3], distance;
    across_axis(toward, sideways, &distance);
    double sine = the_scene.truth.radius / distance, cosine = sqrt(1.0 - sine * sine);
    double middle = dot(the_scene.truth.point, the_scene.truth.direction);
    for (int side = 0; side < 2; side++) {
        for (int end = 0; end < 2; end++) {
            double p[3] = {0.0, 0.0, 0.0};
            add(p, distance * cosine * cosine, toward, p);
            add(p, (side == 0 ? 1.0 : -1.0) * distance * cosine * sine, sideways, p);
            add(p, middle + (end == 0 ? -0.8 : 0.8) * HALF_LENGTH, the_scene.truth.direction, p);
            the_scene.edges[side][2 * end] = camera->fx * p[0] / p[2] + camera->cx;
            the_scene.edges[side][2 * end + 1] = camera->fy * p[1] / p[2] + camera->cy;
        }
    }
}

void make_scene(void)
{
    cylfuse_cylinder truth = {{0.02, -0.01, 0.7}, {0.8, 0.36, 0.48}, 0.05};
    the_scene.truth = truth;
    add(truth.point, -HALF_LENGTH, truth.direction, the_scene.start);
    add(truth.point, HALF_LENGTH, truth.direction, the_scene.end);
    cylfuse_intrinsics *camera = &the_scene.intrinsics;
    CHECK_OK(cylfuse_intrinsics_init(camera, sizeof *camera));
    camera->width = WIDTH;
    camera->height = HEIGHT;
    camera->fx = 200.0;
    camera->fy = 201.0;
    camera->cx = 79.0;
    camera->cy = 60.5;
    make_points();
    make_images();
    make_edges();
}

cylfuse_points_view scene_points(void)
{
    cylfuse_points_view view;
    CHECK_OK(cylfuse_points_view_init(&view, sizeof view));
    view.scalar = CYLFUSE_SCALAR_F64;
    view.data = the_scene.points;
    view.width = COLUMNS;
    view.height = ROWS;
    return view;
}

cylfuse_depth_view scene_depth(void)
{
    cylfuse_depth_view view;
    CHECK_OK(cylfuse_depth_view_init(&view, sizeof view));
    view.format = CYLFUSE_DEPTH_FORMAT_F32;
    view.data = the_scene.depth;
    view.width = WIDTH;
    view.height = HEIGHT;
    return view;
}

cylfuse_mask_view scene_mask(void)
{
    cylfuse_mask_view view;
    CHECK_OK(cylfuse_mask_view_init(&view, sizeof view));
    view.data = the_scene.mask;
    view.width = WIDTH;
    view.height = HEIGHT;
    return view;
}

cylfuse_image_view scene_image(void)
{
    cylfuse_image_view image;
    CHECK_OK(cylfuse_image_view_init(&image, sizeof image));
    image.format = CYLFUSE_IMAGE_FORMAT_F32;
    image.data = the_scene.image;
    image.width = WIDTH;
    image.height = HEIGHT;
    return image;
}

cylfuse_segments_view scene_edges(void)
{
    cylfuse_segments_view view;
    CHECK_OK(cylfuse_segments_view_init(&view, sizeof view));
    view.scalar = CYLFUSE_SCALAR_F64;
    view.data = the_scene.edges;
    view.count = 2;
    return view;
}
