//! Random numbers that depend on what they are for alone, whatever thread asks for them.

/// SplitMix64 (Steele, Lea and Flood 2014).
pub(crate) struct Sampler(u64);

/// The increment: 2^64 over the golden ratio.
const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;

impl Sampler {
    /// A stream of its own for each sample of each pixel, or of each photon.
    pub fn new(seed: u64, pixel: u64, sample: u64) -> Self {
        let mut stream = Self(seed);
        for part in [pixel, sample] {
            stream = Self(stream.bits() ^ part.wrapping_mul(GAMMA));
        }
        stream
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(GAMMA);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * 2.0f64.powi(-53)
    }

    /// Two of them.
    pub fn pair(&mut self) -> [f64; 2] {
        [self.unit(), self.unit()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_uniform_and_differ() {
        let mut bins = [0u32; 16];
        for pixel in 0..1000 {
            for sample in 0..16 {
                let [x, y] = Sampler::new(7, pixel, sample).pair();
                bins[(4.0 * x) as usize * 4 + (4.0 * y) as usize] += 1;
            }
        }
        // 1000 each; five standard deviations.
        assert!(bins.iter().all(|&count| count.abs_diff(1000) < 155), "{bins:?}");
        assert_ne!(Sampler::new(0, 1, 0).unit(), Sampler::new(0, 0, 1).unit());
        assert_ne!(Sampler::new(0, 1, 0).unit(), Sampler::new(1, 1, 0).unit());
    }
}
