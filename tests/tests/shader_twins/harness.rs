//! Runs a test shader over rows of inputs.

use std::sync::LazyLock;

use glam::{DVec3, Vec3, Vec4};
use murano_gpu::{ComputePass, Gpu, Groups, Leaf, ShaderSpec, Work};
use murano_scheduler::{History, Plan, Skipping};
use murano_tests::bench;

/// One device for all tests.
pub static GPU: LazyLock<Gpu> = LazyLock::new(bench::gpu);

/// Runs `entry` of `tests::...` once per case: `inputs` holds its rows case by case, the result `rows` rows a case.
pub fn run(root: &'static str, entry: &'static str, inputs: &[Vec4], cases: usize, rows: usize) -> Vec<Vec<Vec4>> {
    run_with(root, entry, inputs, cases, rows, None)
}

/// As [`run`], with a leaf named `environment`.
pub fn run_with(
    root: &'static str,
    entry: &'static str,
    inputs: &[Vec4],
    cases: usize,
    rows: usize,
    environment: Option<Leaf>,
) -> Vec<Vec<Vec4>> {
    assert_eq!(inputs.len() % cases, 0, "every case has as many rows");
    let shader = GPU.shader(&ShaderSpec::new(root)).unwrap_or_else(|error| panic!("{error}"));
    let mut plan: Plan<Work> = Plan::new();
    let (stamp, leaf) = Leaf::of(inputs);
    let mut pass = ComputePass::new(root, 0).input("inputs", plan.leaf("inputs", stamp, Work::Leaf(leaf)));
    if let Some(environment) = environment {
        // Tests that need one use one and the same.
        let stamp = murano_scheduler::Stamp::of(b"environment of the twins");
        pass = pass.input("environment", plan.leaf("environment", stamp, Work::Leaf(environment)));
    }
    let outputs = pass
        .output("outputs", 16 * (cases * rows) as u64)
        .dispatch(&shader, entry, Groups::linear(cases, 64))
        .add_to(&mut plan)
        .expect("one pass");
    let executed =
        GPU.execute(&plan, &outputs, &mut History::new(), Skipping::Off).unwrap_or_else(|error| panic!("{error}"));
    let read = rows_of(&executed.targets[0]);
    read[..cases * rows].chunks_exact(rows).map(<[Vec4]>::to_vec).collect()
}

/// The vec4f of a buffer.
pub fn rows_of(bytes: &[u8]) -> Vec<Vec4> {
    let number = |bytes: &[u8]| f32::from_le_bytes(bytes.try_into().expect("4 bytes"));
    bytes
        .chunks_exact(16)
        .map(|row| Vec4::from_array(std::array::from_fn(|i| number(&row[4 * i..4 * i + 4]))))
        .collect()
}

/// Random numbers, the same in every run (SplitMix64: Steele, Lea and Flood 2014).
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly in [low, high).
    pub fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.bits() >> 40) as f32 / (1 << 24) as f32
    }

    /// Evenly in the logarithm.
    pub fn magnitude(&mut self, low: f32, high: f32) -> f32 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Any of a list.
    pub fn any<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.bits() as usize % list.len()]
    }

    /// Evenly in the cube [-1, 1)^3.
    pub fn in_cube(&mut self) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| self.between(-1.0, 1.0)))
    }

    /// A direction.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.in_cube();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }
}

/// A row's first three numbers.
pub fn xyz(row: Vec4) -> DVec3 {
    row.truncate().as_dvec3()
}

/// Stops at the first difference beyond the tolerance.
pub fn assert_near(found: f64, wanted: f64, tolerance: f64, what: impl FnOnce() -> String) {
    assert!((found - wanted).abs() <= tolerance, "{}: {found}, not {wanted} within {tolerance:e}", what());
}

/// Stops at the first vector farther off than the tolerance.
pub fn assert_close(found: DVec3, wanted: DVec3, tolerance: f64, what: impl FnOnce() -> String) {
    assert!(found.distance(wanted) <= tolerance, "{}: {found}, not {wanted} within {tolerance:e}", what());
}

/// Stops at the first row that is not finite.
pub fn assert_finite(case: usize, inputs: &[Vec4], outputs: &[Vec4]) {
    assert!(outputs.iter().all(|row| row.is_finite()), "case {case}, {inputs:?}: {outputs:?}");
}
