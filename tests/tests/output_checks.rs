//! The check after every pass: a planted number that is none is found and named, and nothing else is.

use std::f64::consts::PI;

use glam::DVec3;
use murano_gpu::{ComputePass, GpuError, Groups, Leaf, NonFinite, ShaderSpec, Work};
use murano_optics::Ior;
use murano_refraction::Method;
use murano_render::{RenderError, View};
use murano_scene::Projection;
use murano_scheduler::{History, Plan, Skipping};
use murano_tests::bench::{asset, glass_body, gpu, renderer, settings, still};

const ROWS: u32 = 5000;
const WORDS: u32 = 8;

/// Lets `tests::non_finite` write these bits: row, word, bits; returns what the check says of it.
fn check(gpu: &murano_gpu::Gpu, planted: &[[u32; 3]]) -> Result<(), NonFinite> {
    let shader = gpu.shader(&ShaderSpec::new("tests::non_finite")).expect("it links");
    let mut plan: Plan<Work> = Plan::new();
    let leaf: Vec<[u32; 4]> = planted.iter().map(|&[row, word, bits]| [row, word, bits, 1]).collect();
    let (stamp, leaf) = Leaf::of(&leaf);
    let outputs = ComputePass::new("plant", 7)
        .input("planted", plan.leaf("planted", stamp, Work::Leaf(leaf)))
        .output("rows", u64::from(4 * WORDS * ROWS))
        .dispatch(&shader, "main", Groups::linear(ROWS as usize, 64))
        .add_to(&mut plan)
        .expect("one pass");
    match gpu.execute(&plan, &outputs, &mut History::new(), Skipping::On) {
        Ok(_) => Ok(()),
        Err(GpuError::NonFinite(found)) => Err(found),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn a_number_that_is_none_is_found_where_it_was_written() {
    let gpu = gpu();
    for bits in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY].map(f32::to_bits) {
        for (row, word) in [(0, 0), (4711, 2), (ROWS - 1, 5)] {
            let found = check(&gpu, &[[row, word, bits]]).expect_err("it is found");
            let expected = NonFinite { pass: "plant", instance: 7, output: "rows", count: 1, element: row, word };
            assert_eq!(found, expected, "{bits:#x}");
        }
    }
    // A failed frame leaves nothing in the cache: the same plan fails again.
    assert!(check(&gpu, &[[0, 0, f32::NAN.to_bits()]]).is_err());
    let many = check(&gpu, &[[90, 1, f32::NAN.to_bits()], [17, 4, f32::INFINITY.to_bits()], [17, 6, u32::MAX]]);
    let many = many.expect_err("they are found");
    assert_eq!((many.count, many.element, many.word), (2, 17, 4));
    assert_eq!(
        many.to_string(),
        "pass `plant:7`: output `rows` holds 2 numbers that are NaN or infinite, the first in element 17, word 4"
    );
}

#[test]
fn integers_may_hold_any_bits_and_floats_any_number() {
    let gpu = gpu();
    let numbers = [f32::MAX, f32::MIN, f32::MIN_POSITIVE, f32::from_bits(1), -0.0];
    let floats = numbers.iter().zip(0..).map(|(number, row)| [row, 1, number.to_bits()]);
    let integers = [3, 6, 7].map(|word| [99, word, f32::NAN.to_bits()]);
    assert_eq!(check(&gpu, &floats.chain(integers).collect::<Vec<_>>()), Ok(()));
}

/// Cameras of any distance, angle and near plane, lit or not: every pass writes numbers, or the request is refused.
#[test]
fn extreme_cameras_show_numbers_or_are_refused() {
    let mut renderer = renderer(gpu(), glass_body(&asset("prism.glb"), Ior::GLASS));
    let mut random = SplitMix(7);
    let mut refused = 0;
    for _ in 0..150 {
        let magnitude = |random: &mut SplitMix, low: f64, high: f64| (low + (high - low) * random.unit()).exp2();
        let distance = magnitude(&mut random, -30.0, 50.0);
        let towards = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5).normalize_or(DVec3::X);
        // From almost none to almost 180 degrees, most near one of these.
        let narrow = magnitude(&mut random, -40.0, 1.0);
        let yfov = if random.unit() < 0.5 { narrow } else { PI - 1.5 * narrow };
        let target = towards * magnitude(&mut random, -40.0, 3.0);
        let mut view = View::look_at(towards * distance, target, yfov.clamp(1e-300, PI));
        view.near = magnitude(&mut random, -40.0, 40.0);
        if random.unit() < 0.3 {
            view.projection = Projection::Orthographic { half_height: magnitude(&mut random, -60.0, 60.0) };
        }
        let method = Method::ALL[(Method::ALL.len() as f64 * random.unit()) as usize];
        let size = [[24, 24], [1, 64], [300, 2]][(3.0 * random.unit()) as usize];
        match renderer.render(&still(view, size, settings(method, 5))) {
            Ok(_) => {}
            Err(RenderError::Request(_)) => refused += 1,
            Err(error) => panic!("{view:?} {method} {size:?}: {error}"),
        }
    }
    assert!(refused < 75, "{refused} of 150 were refused");
}

/// Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014.
struct SplitMix(u64);

impl SplitMix {
    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
