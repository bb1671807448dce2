//! Points that were left out.

/// How many points were left out, by reason.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// A coordinate or weight is not finite.
    pub not_finite: usize,
    /// The weight is 0.
    pub zero_weight: usize,
    /// The mask is zero there.
    pub outside_mask: usize,
    /// No depth was measured there: zero, negative or not finite.
    pub no_depth: usize,
    /// The depth is outside the range that was asked for.
    pub out_of_range: usize,
    /// The camera model has no ray for the pixel.
    pub outside_camera: usize,
    /// The mask is set there, but the colour camera sees something nearer.
    pub hidden: usize,
}

impl Dropped {
    /// All of them.
    #[must_use]
    pub fn total(&self) -> usize {
        self.not_finite
            + self.zero_weight
            + self.outside_mask
            + self.no_depth
            + self.out_of_range
            + self.outside_camera
            + self.hidden
    }

    /// Why points were left out, with numbers, in parentheses; empty where none was.
    pub(crate) fn in_words(&self) -> String {
        let reasons = [
            (self.not_finite, "not finite"),
            (self.zero_weight, "of weight 0"),
            (self.outside_mask, "outside the mask"),
            (self.no_depth, "without a depth"),
            (self.out_of_range, "out of the range of depths"),
            (self.outside_camera, "outside the field of the camera"),
            (self.hidden, "hidden by something nearer"),
        ];
        let words = reasons.iter().filter(|(count, _)| *count > 0);
        let words: Vec<String> = words.map(|(count, reason)| format!("{count} {reason}")).collect();
        if words.is_empty() { String::new() } else { format!(" ({})", words.join(", ")) }
    }

    pub(crate) fn add(&mut self, other: &Dropped) {
        self.not_finite += other.not_finite;
        self.zero_weight += other.zero_weight;
        self.outside_mask += other.outside_mask;
        self.no_depth += other.no_depth;
        self.out_of_range += other.out_of_range;
        self.outside_camera += other.outside_camera;
        self.hidden += other.hidden;
    }
}
