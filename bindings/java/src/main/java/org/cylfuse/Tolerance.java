package org.cylfuse;

import com.sun.jna.ptr.IntByReference;
import java.util.Set;

/**
 * The limits of a radius, a diameter or another length.
 *
 * @param lower the lower limit, which conforms itself; negative infinity for none
 * @param upper the upper limit likewise, greater than the lower one; infinity for none
 * @param coverage the coverage factor k: standard deviations on either side of a value; 0 = 2
 */
public record Tolerance(double lower, double upper, double coverage) {
    /**
     * Limits with the coverage factor 2.
     *
     * @param lower the lower limit
     * @param upper the upper limit
     */
    public Tolerance(double lower, double upper) {
        this(lower, upper, 2.0);
    }

    /**
     * Decides by the rule of ISO 14253-1 whether a length conforms: only where the value with {@link #coverage()} deviations
     * on either side lies within the limits, and not only where it lies outside. {@link FitResult#radiusConforms} and {@link
     * FitResult#diameterConforms} ask for those of a fit.
     *
     * @param value the value
     * @param deviation its standard deviation; NaN, and 0 as of a radius that the limits of the fit fix, decide nothing. A
     *     wrong scale of the depth and wrong intrinsics are in none.
     * @param flags the warnings of the result. With one of which a deviation says nothing, such as {@link ResultFlag#POOR_FIT}
     *     or {@link ResultFlag#RADIUS_AT_LIMIT}, nothing is decided.
     * @return what the measurement says
     * @throws CylfuseException INVALID_ARGUMENT for limits, a value or a deviation that are none
     */
    public Conformity decide(double value, double deviation, Set<ResultFlag> flags) {
        int bits = 0;
        for (ResultFlag flag : flags) {
            bits |= flag.value();
        }
        IntByReference conformity = new IntByReference();
        NativeFunctions.check(
                NativeFunctions.cylfuse_decide_conformity(value, deviation, bits, lower, upper, coverage, conformity));
        return NativeNumber.find(Conformity.class, conformity.getValue());
    }
}
