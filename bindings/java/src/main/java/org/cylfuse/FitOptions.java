package org.cylfuse;

import java.util.Objects;

/**
 * The settings of a fit. The constructor fills in the defaults, which are named below. Each setting has a method that
 * reads it and one that sets it and returns the options.
 */
public final class FitOptions extends NoiseOptions {
    /** The defaults of the library. */
    public FitOptions() {
        this(NativeFunctions.initialised(new NativeStructs.Options(), NativeFunctions::cylfuse_options_init));
    }

    FitOptions(NativeStructs.Options n) {
        super(n);
    }

    /** {@return how the cylinder is estimated. Default FUSED} */
    public Method method() {
        return NativeNumber.find(Method.class, n.method);
    }

    /**
     * Sets {@link #method()}.
     *
     * @param method the setting
     * @return these options
     */
    public FitOptions method(Method method) {
        n.method = Objects.requireNonNull(method, "method").value();
        return this;
    }

    /** {@return what FUSED minimises. Default ROBUST} */
    public Objective objective() {
        return NativeNumber.find(Objective.class, n.objective);
    }

    /**
     * Sets {@link #objective()}.
     *
     * @param objective the setting
     * @return these options
     */
    public FitOptions objective(Objective objective) {
        n.objective = Objects.requireNonNull(objective, "objective").value();
        return this;
    }

    /** {@return where the iteration starts. Default AUTO} */
    public StartKind start() {
        return NativeNumber.find(StartKind.class, n.start);
    }

    /**
     * Sets {@link #start()}.
     *
     * @param start the setting
     * @return these options
     */
    public FitOptions start(StartKind start) {
        n.start = Objects.requireNonNull(start, "start").value();
        return this;
    }

    /** {@return whether the points must lie on the wall that the camera sees. Default AUTO} */
    public NearWall nearWall() {
        return NativeNumber.find(NearWall.class, n.near_wall);
    }

    /**
     * Sets {@link #nearWall()}.
     *
     * @param nearWall the setting
     * @return these options
     */
    public FitOptions nearWall(NearWall nearWall) {
        n.near_wall = Objects.requireNonNull(nearWall, "nearWall").value();
        return this;
    }

    /** {@return the coordinates of the iteration. Default AUTO} */
    public Chart chart() {
        return NativeNumber.find(Chart.class, n.chart);
    }

    /**
     * Sets {@link #chart()}.
     *
     * @param chart the setting
     * @return these options
     */
    public FitOptions chart(Chart chart) {
        n.chart = Objects.requireNonNull(chart, "chart").value();
        return this;
    }

    /** {@return what given edge segments are for the objective ROBUST. Default REFINE} */
    public EdgeUse edgeUse() {
        return NativeNumber.find(EdgeUse.class, n.edge_use);
    }

    /**
     * Sets {@link #edgeUse()}.
     *
     * @param edgeUse the setting
     * @return these options
     */
    public FitOptions edgeUse(EdgeUse edgeUse) {
        n.edge_use = Objects.requireNonNull(edgeUse, "edgeUse").value();
        return this;
    }

    /** {@return how the ends of the visible cylinder are found. Default AUTO} */
    public ExtentRule extentRule() {
        return NativeNumber.find(ExtentRule.class, n.extent_rule);
    }

    /**
     * Sets {@link #extentRule()}.
     *
     * @param extentRule the setting
     * @return these options
     */
    public FitOptions extentRule(ExtentRule extentRule) {
        n.extent_rule = Objects.requireNonNull(extentRule, "extentRule").value();
        return this;
    }

    /**
     * {@return the most threads for the sums over the points; small clouds take one. The result has the same bits for
     * any number. Default 1: no thread is started; 0 = 1}
     */
    public int maxThreads() {
        return n.max_threads;
    }

    /**
     * Sets {@link #maxThreads()}.
     *
     * @param maxThreads the setting
     * @return these options
     */
    public FitOptions maxThreads(int maxThreads) {
        n.max_threads = (int) notNegative("maxThreads", maxThreads);
        return this;
    }

    /** {@return the maximum number of iterations, at least 1. Default 400} */
    public int maxIterations() {
        return n.max_iterations;
    }

    /**
     * Sets {@link #maxIterations()}.
     *
     * @param maxIterations the setting
     * @return these options
     */
    public FitOptions maxIterations(int maxIterations) {
        n.max_iterations = (int) notNegative("maxIterations", maxIterations);
        return this;
    }

    /** {@return the smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12} */
    public double costTolerance() {
        return n.cost_tolerance;
    }

    /**
     * Sets {@link #costTolerance()}.
     *
     * @param costTolerance the setting
     * @return these options
     */
    public FitOptions costTolerance(double costTolerance) {
        n.cost_tolerance = costTolerance;
        return this;
    }

    /**
     * {@return the iteration ends where the cosine of the angle between the residuals and what a step can change of
     * them is not above this, in [0, 1). Default 2^-52}
     */
    public double gradientTolerance() {
        return n.gradient_tolerance;
    }

    /**
     * Sets {@link #gradientTolerance()}.
     *
     * @param gradientTolerance the setting
     * @return these options
     */
    public FitOptions gradientTolerance(double gradientTolerance) {
        n.gradient_tolerance = gradientTolerance;
        return this;
    }

    /**
     * {@return the iteration ends with a step that moves the surface at the data by not more than this part of their
     * largest coordinate and of their size, in [0, 1). Default 2^-52}
     */
    public double stepTolerance() {
        return n.step_tolerance;
    }

    /**
     * Sets {@link #stepTolerance()}.
     *
     * @param stepTolerance the setting
     * @return these options
     */
    public FitOptions stepTolerance(double stepTolerance) {
        n.step_tolerance = stepTolerance;
        return this;
    }

    /** {@return the damping of the first step, greater than 0. Default 1e-3} */
    public double initialLambda() {
        return n.initial_lambda;
    }

    /**
     * Sets {@link #initialLambda()}.
     *
     * @param initialLambda the setting
     * @return these options
     */
    public FitOptions initialLambda(double initialLambda) {
        n.initial_lambda = initialLambda;
        return this;
    }

    /**
     * {@return the factor by which the damping falls after an accepted step and grows after a rejected one, greater
     * than 1. Default 10}
     */
    public double lambdaFactor() {
        return n.lambda_factor;
    }

    /**
     * Sets {@link #lambdaFactor()}.
     *
     * @param lambdaFactor the setting
     * @return these options
     */
    public FitOptions lambdaFactor(double lambdaFactor) {
        n.lambda_factor = lambdaFactor;
        return this;
    }

    /**
     * {@return the damping at which no smaller step is tried any more, at least {@link #initialLambda()}. Default 1e12}
     */
    public double maxLambda() {
        return n.max_lambda;
    }

    /**
     * Sets {@link #maxLambda()}.
     *
     * @param maxLambda the setting
     * @return these options
     */
    public FitOptions maxLambda(double maxLambda) {
        n.max_lambda = maxLambda;
        return this;
    }

    /** {@return the weight w of the edges in PAPER, in [0, 1]. Default 0.6; 0 is points only} */
    public double edgeWeight() {
        return n.edge_weight;
    }

    /**
     * Sets {@link #edgeWeight()}.
     *
     * @param edgeWeight the setting
     * @return these options
     */
    public FitOptions edgeWeight(double edgeWeight) {
        n.edge_weight = edgeWeight;
        return this;
    }

    /** {@return the seed of the random samples of RANSAC: the same seed gives the same result. Default 0} */
    public long seed() {
        return n.seed;
    }

    /**
     * Sets {@link #seed()}.
     *
     * @param seed the setting
     * @return these options
     */
    public FitOptions seed(long seed) {
        n.seed = seed;
        return this;
    }

    /** {@return the most random samples of RANSAC, 1 to 1,000,000. Default 1000} */
    public long ransacMaxIterations() {
        return n.ransac_max_iterations;
    }

    /**
     * Sets {@link #ransacMaxIterations()}.
     *
     * @param ransacMaxIterations the setting
     * @return these options
     */
    public FitOptions ransacMaxIterations(long ransacMaxIterations) {
        n.ransac_max_iterations = notNegative("ransacMaxIterations", ransacMaxIterations);
        return this;
    }

    /**
     * {@return the distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater.
     * Default 0 = from the data}
     */
    public double ransacThreshold() {
        return n.ransac_threshold;
    }

    /**
     * Sets {@link #ransacThreshold()}.
     *
     * @param ransacThreshold the setting
     * @return these options
     */
    public FitOptions ransacThreshold(double ransacThreshold) {
        n.ransac_threshold = ransacThreshold;
        return this;
    }

    /**
     * {@return the smallest radius, in the unit of length, which the returned cylinder keeps whatever the method and
     * the start. Default 0 = no limit}
     */
    public double radiusMin() {
        return n.radius_min;
    }

    /**
     * Sets {@link #radiusMin()}.
     *
     * @param radiusMin the setting
     * @return these options
     */
    public FitOptions radiusMin(double radiusMin) {
        n.radius_min = radiusMin;
        return this;
    }

    /**
     * {@return the largest radius, at least {@link #radiusMin()}; equal to it for a radius that is known. Default 0 =
     * no limit}
     */
    public double radiusMax() {
        return n.radius_max;
    }

    /**
     * Sets {@link #radiusMax()}.
     *
     * @param radiusMax the setting
     * @return these options
     */
    public FitOptions radiusMax(double radiusMax) {
        n.radius_max = radiusMax;
        return this;
    }

    /**
     * {@return the middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0} =
     * all directions}
     */
    public Vector axis() {
        return Vector.of(n.axis);
    }

    /**
     * Sets {@link #axis()}.
     *
     * @param axis the setting
     * @return these options
     */
    public FitOptions axis(Vector axis) {
        n.axis = Objects.requireNonNull(axis, "axis").toArray();
        return this;
    }

    /**
     * {@return the largest angle of the axis from {@link #axis()}, in radians from 0 to pi/2, whatever the signs; 0 for
     * a direction that is known. Default 0; must be 0 without {@link #axis()}}
     */
    public double axisMaxAngle() {
        return n.axis_max_angle;
    }

    /**
     * Sets {@link #axisMaxAngle()}.
     *
     * @param axisMaxAngle the setting
     * @return these options
     */
    public FitOptions axisMaxAngle(double axisMaxAngle) {
        n.axis_max_angle = axisMaxAngle;
        return this;
    }

    NativeStructs.Options toNative() {
        return n;
    }

    private static long notNegative(String name, long value) {
        if (value < 0) {
            throw new IllegalArgumentException(name + " is " + value + "; it must be 0 or greater.");
        }
        return value;
    }
}
