//! Random numbers that are the same on every machine.

/// `SplitMix64` (Steele, Lea, Flood 2014): one multiplication chain per number, good enough to draw samples.
#[derive(Debug, Clone)]
pub struct Random(u64);

impl Random {
    /// The sequence of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// A number from 0 up to but not including `end`; 0 when `end` is 0.
    pub fn below(&mut self, end: usize) -> usize {
        ((u128::from(self.bits()) * end as u128) >> 64) as usize
    }

    /// A number from 0 up to but not including 1.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A number from `low` up to but not including `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A number that is normal to within three standard deviations of 1, and bounded: noise for tests.
    #[cfg(test)]
    pub fn bell(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One of these values, each as likely as its weight says; the last when the weights are all 0.
    pub fn weighted<T: Copy, const N: usize>(&mut self, choices: [(T, f64); N]) -> T {
        const { assert!(N > 0) };
        let mut left = self.unit() * choices.iter().map(|(_, weight)| weight).sum::<f64>();
        for (value, weight) in choices {
            left -= weight;
            if left < 0.0 {
                return value;
            }
        }
        choices[N - 1].0
    }

    /// Puts a slice in random order (Fisher and Yates).
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// A seed that depends on every byte of an id (FNV-1a).
pub fn seed_of(id: &str) -> u64 {
    fnv1a(0xcbf2_9ce4_8422_2325, id)
}

/// A number that depends on the seed and on every byte of the text (FNV-1a, mixed).
pub fn hash(seed: u64, text: &str) -> u64 {
    Random::new(fnv1a(Random::new(seed).bits(), text)).bits()
}

fn fnv1a(start: u64, text: &str) -> u64 {
    text.bytes().fold(start, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        // First outputs of the reference implementation for seed 1234567.
        let mut random = Random::new(1_234_567);
        assert_eq!([random.bits(), random.bits()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
    }

    #[test]
    fn draws_are_even_and_in_range() {
        let mut random = Random::new(7);
        let mut counts = [0; 5];
        for _ in 0..10_000 {
            counts[random.below(5)] += 1;
            assert!((0.0..1.0).contains(&random.unit()));
        }
        assert!(counts.iter().all(|c| (1_850..2_150).contains(c)), "{counts:?}");
        let mut heavy = 0;
        for _ in 0..10_000 {
            heavy += random.weighted([(1, 3.0), (0, 1.0), (5, 0.0)]);
            assert!((-2.0..-1.0).contains(&random.between(-2.0, -1.0)));
        }
        assert!((7_300..7_700).contains(&heavy), "{heavy}");
        let mut items: Vec<u32> = (0..50).collect();
        random.shuffle(&mut items);
        assert_ne!(items, (0..50).collect::<Vec<_>>());
        items.sort_unstable();
        assert_eq!(items, (0..50).collect::<Vec<_>>());
    }
}
