package org.cylfuse;

import java.util.Objects;

/**
 * The settings of a fit. The constructor fills in the defaults, which are named below; a number that says "0 =
 * default" may also be left 0. Each setting has a method that reads it and one that sets it and returns the options.
 */
public final class FitOptions {
    private Method method;
    private Objective objective;
    private StartKind start;
    private NearWall nearWall;
    private Chart chart;
    private int maxIterations;
    private int maxThreads;
    private double edgeWeight;
    private double initialLambda;
    private double lambdaFactor;
    private double maxLambda;
    private double costTolerance;
    private double ransacThreshold;
    private long seed;
    private int ransacMaxIterations;
    private EdgeUse edgeUse;
    private ExtentRule extentRule;
    private double radiusMin;
    private double radiusMax;
    private Vector axis;
    private double axisMaxAngle;

    /** The defaults of the library. */
    public FitOptions() {
        NativeStructs.Options n = new NativeStructs.Options();
        NativeFunctions.check(NativeFunctions.cylfuse_options_init(n, n.size()));
        read(n);
    }

    FitOptions(NativeStructs.Options n) {
        read(n);
    }

    /** {@return how the cylinder is estimated. Default FUSED} */
    public Method method() {
        return method;
    }

    /**
     * Sets {@link #method()}.
     *
     * @param method the setting
     * @return these options
     */
    public FitOptions method(Method method) {
        this.method = Objects.requireNonNull(method, "method");
        return this;
    }

    /** {@return what FUSED minimises. Default ROBUST} */
    public Objective objective() {
        return objective;
    }

    /**
     * Sets {@link #objective()}.
     *
     * @param objective the setting
     * @return these options
     */
    public FitOptions objective(Objective objective) {
        this.objective = Objects.requireNonNull(objective, "objective");
        return this;
    }

    /** {@return where the iteration starts. Default AUTO} */
    public StartKind start() {
        return start;
    }

    /**
     * Sets {@link #start()}.
     *
     * @param start the setting
     * @return these options
     */
    public FitOptions start(StartKind start) {
        this.start = Objects.requireNonNull(start, "start");
        return this;
    }

    /** {@return whether the points must lie on the wall that the camera sees. Default AUTO} */
    public NearWall nearWall() {
        return nearWall;
    }

    /**
     * Sets {@link #nearWall()}.
     *
     * @param nearWall the setting
     * @return these options
     */
    public FitOptions nearWall(NearWall nearWall) {
        this.nearWall = Objects.requireNonNull(nearWall, "nearWall");
        return this;
    }

    /** {@return the coordinates of the iteration. Default AUTO} */
    public Chart chart() {
        return chart;
    }

    /**
     * Sets {@link #chart()}.
     *
     * @param chart the setting
     * @return these options
     */
    public FitOptions chart(Chart chart) {
        this.chart = Objects.requireNonNull(chart, "chart");
        return this;
    }

    /** {@return the most linear solves. Default 400; 0 = default} */
    public int maxIterations() {
        return maxIterations;
    }

    /**
     * Sets {@link #maxIterations()}.
     *
     * @param maxIterations the setting
     * @return these options
     */
    public FitOptions maxIterations(int maxIterations) {
        if (maxIterations < 0) {
            throw new IllegalArgumentException("maxIterations is " + maxIterations + "; it must be 0 or greater.");
        }
        this.maxIterations = maxIterations;
        return this;
    }

    /**
     * {@return the most threads for the sums over the points; small clouds take one. The result has the same bits for
     * any number. Default 0 = as many as the machine has}
     */
    public int maxThreads() {
        return maxThreads;
    }

    /**
     * Sets {@link #maxThreads()}.
     *
     * @param maxThreads the setting
     * @return these options
     */
    public FitOptions maxThreads(int maxThreads) {
        if (maxThreads < 0) {
            throw new IllegalArgumentException("maxThreads is " + maxThreads + "; it must be 0 or greater.");
        }
        this.maxThreads = maxThreads;
        return this;
    }

    /** {@return the weight w of the edges in PAPER, in [0, 1]. Default 0.6. Here 0 is a weight: points only} */
    public double edgeWeight() {
        return edgeWeight;
    }

    /**
     * Sets {@link #edgeWeight()}.
     *
     * @param edgeWeight the setting
     * @return these options
     */
    public FitOptions edgeWeight(double edgeWeight) {
        this.edgeWeight = edgeWeight;
        return this;
    }

    /** {@return the damping of the first step, greater than 0. Default 1e-3; 0 = default} */
    public double initialLambda() {
        return initialLambda;
    }

    /**
     * Sets {@link #initialLambda()}.
     *
     * @param initialLambda the setting
     * @return these options
     */
    public FitOptions initialLambda(double initialLambda) {
        this.initialLambda = initialLambda;
        return this;
    }

    /**
     * {@return the factor by which the damping falls after an accepted step and grows after a rejected one, greater
     * than 1. Default 10; 0 = default}
     */
    public double lambdaFactor() {
        return lambdaFactor;
    }

    /**
     * Sets {@link #lambdaFactor()}.
     *
     * @param lambdaFactor the setting
     * @return these options
     */
    public FitOptions lambdaFactor(double lambdaFactor) {
        this.lambdaFactor = lambdaFactor;
        return this;
    }

    /**
     * {@return the damping at which no smaller step is tried any more, at least {@link #initialLambda()}. Default
     * 1e12; 0 = default}
     */
    public double maxLambda() {
        return maxLambda;
    }

    /**
     * Sets {@link #maxLambda()}.
     *
     * @param maxLambda the setting
     * @return these options
     */
    public FitOptions maxLambda(double maxLambda) {
        this.maxLambda = maxLambda;
        return this;
    }

    /**
     * {@return the smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12. Here 0
     * is a tolerance: iterate until nothing decreases}
     */
    public double costTolerance() {
        return costTolerance;
    }

    /**
     * Sets {@link #costTolerance()}.
     *
     * @param costTolerance the setting
     * @return these options
     */
    public FitOptions costTolerance(double costTolerance) {
        this.costTolerance = costTolerance;
        return this;
    }

    /**
     * {@return the distance within which RANSAC counts a point as an inlier, in the unit of length, 0 or greater.
     * Default 0 = from the data}
     */
    public double ransacThreshold() {
        return ransacThreshold;
    }

    /**
     * Sets {@link #ransacThreshold()}.
     *
     * @param ransacThreshold the setting
     * @return these options
     */
    public FitOptions ransacThreshold(double ransacThreshold) {
        this.ransacThreshold = ransacThreshold;
        return this;
    }

    /** {@return the seed of the random samples of RANSAC: the same seed gives the same result. Default 0} */
    public long seed() {
        return seed;
    }

    /**
     * Sets {@link #seed()}.
     *
     * @param seed the setting
     * @return these options
     */
    public FitOptions seed(long seed) {
        this.seed = seed;
        return this;
    }

    /** {@return the most random samples of RANSAC. Default 1000; 0 = default} */
    public int ransacMaxIterations() {
        return ransacMaxIterations;
    }

    /**
     * Sets {@link #ransacMaxIterations()}.
     *
     * @param ransacMaxIterations the setting
     * @return these options
     */
    public FitOptions ransacMaxIterations(int ransacMaxIterations) {
        if (ransacMaxIterations < 0) {
            throw new IllegalArgumentException("ransacMaxIterations is " + ransacMaxIterations + "; it must be 0 or greater.");
        }
        this.ransacMaxIterations = ransacMaxIterations;
        return this;
    }

    /** {@return what given edge segments are for the objective ROBUST. Default REFINE} */
    public EdgeUse edgeUse() {
        return edgeUse;
    }

    /**
     * Sets {@link #edgeUse()}.
     *
     * @param edgeUse the setting
     * @return these options
     */
    public FitOptions edgeUse(EdgeUse edgeUse) {
        this.edgeUse = Objects.requireNonNull(edgeUse, "edgeUse");
        return this;
    }

    /** {@return how the ends of the visible cylinder are found. Default AUTO} */
    public ExtentRule extentRule() {
        return extentRule;
    }

    /**
     * Sets {@link #extentRule()}.
     *
     * @param extentRule the setting
     * @return these options
     */
    public FitOptions extentRule(ExtentRule extentRule) {
        this.extentRule = Objects.requireNonNull(extentRule, "extentRule");
        return this;
    }

    /**
     * {@return the smallest radius, in the unit of length, which the returned cylinder keeps whatever the method and
     * the start. Default 0 = no limit}
     */
    public double radiusMin() {
        return radiusMin;
    }

    /**
     * Sets {@link #radiusMin()}.
     *
     * @param radiusMin the setting
     * @return these options
     */
    public FitOptions radiusMin(double radiusMin) {
        this.radiusMin = radiusMin;
        return this;
    }

    /**
     * {@return the largest radius, at least {@link #radiusMin()}; equal to it for a radius that is known. Default 0 =
     * no limit}
     */
    public double radiusMax() {
        return radiusMax;
    }

    /**
     * Sets {@link #radiusMax()}.
     *
     * @param radiusMax the setting
     * @return these options
     */
    public FitOptions radiusMax(double radiusMax) {
        this.radiusMax = radiusMax;
        return this;
    }

    /**
     * {@return the middle of the cone of directions that the returned axis keeps, of any length. Default {0, 0, 0} =
     * all directions}
     */
    public Vector axis() {
        return axis;
    }

    /**
     * Sets {@link #axis()}.
     *
     * @param axis the setting
     * @return these options
     */
    public FitOptions axis(Vector axis) {
        this.axis = Objects.requireNonNull(axis, "axis");
        return this;
    }

    /**
     * {@return the largest angle of the axis from {@link #axis()}, in radians from 0 to pi/2, whatever the signs; 0
     * for a direction that is known. Default 0; must be 0 without {@link #axis()}}
     */
    public double axisMaxAngle() {
        return axisMaxAngle;
    }

    /**
     * Sets {@link #axisMaxAngle()}.
     *
     * @param axisMaxAngle the setting
     * @return these options
     */
    public FitOptions axisMaxAngle(double axisMaxAngle) {
        this.axisMaxAngle = axisMaxAngle;
        return this;
    }

    NativeStructs.Options toNative() {
        NativeStructs.Options n = new NativeStructs.Options();
        NativeFunctions.check(NativeFunctions.cylfuse_options_init(n, n.size()));
        n.method = method.value();
        n.objective = objective.value();
        n.start = start.value();
        n.near_wall = nearWall.value();
        n.chart = chart.value();
        n.max_iterations = maxIterations;
        n.max_threads = maxThreads;
        n.edge_weight = edgeWeight;
        n.initial_lambda = initialLambda;
        n.lambda_factor = lambdaFactor;
        n.max_lambda = maxLambda;
        n.cost_tolerance = costTolerance;
        n.ransac_threshold = ransacThreshold;
        n.seed = seed;
        n.ransac_max_iterations = ransacMaxIterations;
        n.edge_use = edgeUse.value();
        n.extent_rule = extentRule.value();
        n.radius_min = radiusMin;
        n.radius_max = radiusMax;
        n.axis = axis.toArray();
        n.axis_max_angle = axisMaxAngle;
        return n;
    }

    private void read(NativeStructs.Options n) {
        method = NativeNumber.find(Method.class, n.method);
        objective = NativeNumber.find(Objective.class, n.objective);
        start = NativeNumber.find(StartKind.class, n.start);
        nearWall = NativeNumber.find(NearWall.class, n.near_wall);
        chart = NativeNumber.find(Chart.class, n.chart);
        maxIterations = n.max_iterations;
        maxThreads = n.max_threads;
        edgeWeight = n.edge_weight;
        initialLambda = n.initial_lambda;
        lambdaFactor = n.lambda_factor;
        maxLambda = n.max_lambda;
        costTolerance = n.cost_tolerance;
        ransacThreshold = n.ransac_threshold;
        seed = n.seed;
        ransacMaxIterations = n.ransac_max_iterations;
        edgeUse = NativeNumber.find(EdgeUse.class, n.edge_use);
        extentRule = NativeNumber.find(ExtentRule.class, n.extent_rule);
        radiusMin = n.radius_min;
        radiusMax = n.radius_max;
        axis = Vector.of(n.axis);
        axisMaxAngle = n.axis_max_angle;
    }
}
