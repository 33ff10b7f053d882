//! A clip made ready to be sampled: curves with the same key times share one search, their keys lie side by side, and what is
//! constant about a pair of rotations is computed once.
//!
//! Rotations, scales and weights in f32, translations in f64, for a node may be a million metres away; the twin in f64 is
//! [`crate::Pose::sample`].

use std::f64::consts::FRAC_PI_2;
use std::ops::Add;

use glam::{DVec3, DVec4, Quat, Vec3A, Vec4};
use murano_scene::{Channel, Clip, Interpolation, Local, Path, Property, PropertyChannel, Sampler, Scene};

use crate::sample::{Moment, locate};

/// What a clip writes into: one entry a node, morph weights of all nodes one after the other.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Locals {
    pub translations: Vec<DVec3>,
    pub rotations: Vec<Quat>,
    pub scales: Vec<Vec3A>,
    pub weights: Vec<f32>,
}

impl Locals {
    /// Takes over all values of another; no allocation where the sizes are the same.
    pub fn copy_from(&mut self, other: &Self) {
        self.translations.clone_from(&other.translations);
        self.rotations.clone_from(&other.rotations);
        self.scales.clone_from(&other.scales);
        self.weights.clone_from(&other.weights);
    }
}

/// Curves of one kind that share their key times and interpolation. Row `k` holds key `k` of every curve; for cubic splines
/// rows `3 k`, `3 k + 1` and `3 k + 2` hold in-tangents, values and out-tangents.
#[derive(Clone, Debug)]
struct Group<V> {
    slots: Vec<u32>,
    rows: Vec<V>,
}

impl<V> Default for Group<V> {
    fn default() -> Self {
        Self { slots: Vec::new(), rows: Vec::new() }
    }
}

/// A moment, the same for all curves of a [`Timeline`].
#[derive(Clone, Copy)]
enum Mix {
    /// A row as it is.
    Row(usize),
    /// Two rows by shares.
    Two { first: usize, share: f64 },
    /// Four rows by Hermite weights: value, out-tangent, next in-tangent, next value.
    Four { rows: [usize; 4], weights: [f64; 4] },
}

/// What a curve gives.
trait Value: Copy + Add<Output = Self> {
    fn times(self, factor: f64) -> Self;
}

impl Value for DVec3 {
    fn times(self, factor: f64) -> Self {
        self * factor
    }
}

impl Value for Vec3A {
    fn times(self, factor: f64) -> Self {
        self * factor as f32
    }
}

impl Value for Quat {
    fn times(self, factor: f64) -> Self {
        self * factor as f32
    }
}

impl Value for f32 {
    fn times(self, factor: f64) -> Self {
        self * factor as f32
    }
}

impl<V: Value> Group<V> {
    fn row(&self, row: usize) -> &[V] {
        &self.rows[row * self.slots.len()..][..self.slots.len()]
    }

    /// Writes the value of every curve. `finish` mends what keys and splines are not by themselves: unit.
    fn write(&self, mix: Mix, out: &mut [V], finish: impl Fn(V) -> V) {
        match mix {
            Mix::Row(row) => {
                for (&slot, &value) in self.slots.iter().zip(self.row(row)) {
                    out[slot as usize] = finish(value);
                }
            }
            Mix::Two { first, share } => {
                let (from, to) = (self.row(first), self.row(first + 1));
                for ((&slot, &a), &b) in self.slots.iter().zip(from).zip(to) {
                    out[slot as usize] = a.times(1.0 - share) + b.times(share);
                }
            }
            Mix::Four { rows, weights: [wa, wb, wc, wd] } => {
                let [a, b, c, d] = rows.map(|row| self.row(row));
                for (index, &slot) in self.slots.iter().enumerate() {
                    let sum = a[index].times(wa) + b[index].times(wb) + c[index].times(wc) + d[index].times(wd);
                    out[slot as usize] = finish(sum);
                }
            }
        }
    }
}

/// Rotations with linear keys: every pair of keys on one hemisphere, its angle known.
#[derive(Clone, Debug, Default)]
struct Arcs {
    group: Group<Quat>,
    /// Squares of the angles between a key and the next, radians, four curves together; a row shorter than `group`.
    squares: Vec<Vec4>,
    /// Angles over their sines, likewise.
    factors: Vec<Vec4>,
}

/// sin(x) / x from x squared, for x up to a quarter turn: to 4e-8 (Taylor, six terms).
fn sinc(square: Vec4) -> Vec4 {
    const TERMS: [f32; 6] = [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0, -1.0 / 39_916_800.0];
    TERMS.iter().rev().fold(Vec4::ZERO, |sum, &term| sum * square + term)
}

impl Arcs {
    /// Keys row by row, unit. Turns every key to the hemisphere of the one before and measures the angles. Which hemisphere that is
    /// is decided in f64: keys half a turn apart lie on its border.
    fn over(slots: Vec<u32>, mut keys: Vec<DVec4>) -> Self {
        let width = slots.len();
        let fours = width.div_ceil(4);
        let pairs = keys.len().checked_div(width).map_or(0, |keys| keys.saturating_sub(1));
        let (mut squares, mut factors) = (vec![Vec4::ZERO; pairs * fours], vec![Vec4::ONE; pairs * fours]);
        for index in width..keys.len() {
            let (before, own) = (keys[index - width], keys[index]);
            if before.dot(own) < 0.0 {
                keys[index] = -own;
            }
            let angle = 2.0 * (keys[index] - before).length().atan2((keys[index] + before).length());
            let angle = angle.min(FRAC_PI_2);
            let (pair, curve) = (index / width - 1, index % width);
            let place = pair * fours + curve / 4;
            squares[place][curve % 4] = (angle * angle) as f32;
            factors[place][curve % 4] = if angle < 1e-9 { 1.0 } else { (angle / angle.sin()) as f32 };
        }
        let rows = keys.into_iter().map(|key| Quat::from_vec4(key.as_vec4())).collect();
        Self { group: Group { slots, rows }, squares, factors }
    }

    /// Shortest-path spherical interpolation, at constant speed.
    fn write(&self, mix: Mix, out: &mut [Quat]) {
        let Mix::Two { first, share } = mix else { return self.group.write(mix, out, |rotation| rotation) };
        let (slots, width) = (&self.group.slots, self.group.slots.len());
        let (from, to) = (self.group.row(first), self.group.row(first + 1));
        let fours = width.div_ceil(4);
        let squares = &self.squares[first * fours..][..fours];
        let factors = &self.factors[first * fours..][..fours];
        let (share, rest) = (share as f32, (1.0 - share) as f32);
        let curves = slots.chunks(4).zip(from.chunks(4)).zip(to.chunks(4));
        for (((slots, from), to), (&square, &factor)) in curves.zip(squares.iter().zip(factors)) {
            let near = (rest * factor * sinc(rest * rest * square)).to_array();
            let far = (share * factor * sinc(share * share * square)).to_array();
            for (lane, &slot) in slots.iter().enumerate() {
                out[slot as usize] =
                    Quat::from_vec4(Vec4::from(from[lane]) * near[lane] + Vec4::from(to[lane]) * far[lane]);
            }
        }
    }
}

/// All curves with the same key times and interpolation.
#[derive(Clone, Debug)]
struct Timeline {
    interpolation: Interpolation,
    times: Vec<f32>,
    translations: Group<DVec3>,
    scales: Group<Vec3A>,
    arcs: Arcs,
    /// Rotations that are not linear.
    rotations: Group<Quat>,
    weights: Group<f32>,
}

/// A clip made ready.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tracks {
    timelines: Vec<Timeline>,
}

impl Tracks {
    /// Sorts the curves of a clip. Channels without effect (of no node, too short) are left out, as are those of nodes with a
    /// matrix. `weights` tells where the morph weights of each node begin.
    pub fn new(scene: &Scene, clip: &Clip, weights: &[u32]) -> Self {
        let mut sorted: Vec<Members> = Vec::new();
        for channel in &clip.channels {
            let Channel { node, path, sampler } = channel;
            let Some(owner) = scene.nodes.get(*node) else { continue };
            let moves = !matches!(owner.local, Local::Matrix(_)) || *path == Path::Weights;
            if !moves || !is_whole(sampler, *path) {
                continue;
            }
            let members = Members::like(&mut sorted, sampler);
            if *path == Path::Weights {
                let count = sampler.width.min(owner.weights.len());
                members.weights.extend((0..count).map(|target| (sampler, target, weights[*node] + target as u32)));
            } else {
                members.channels.push(channel);
            }
        }
        // Behind all lists of weights, of which they change one.
        let mut single: Vec<Members> = Vec::new();
        for PropertyChannel { property, sampler } in &clip.properties {
            let Property::Weight(node, target) = *property else { continue };
            let driven = scene.nodes.get(node).is_some_and(|node| target < node.weights.len());
            if driven && is_whole(sampler, Path::Weights) && sampler.width == 1 {
                Members::like(&mut single, sampler).weights.push((sampler, 0, weights[node] + target as u32));
            }
        }
        Self { timelines: sorted.iter().chain(&single).map(Timeline::of).collect() }
    }

    /// Writes every curve's value at a time in seconds.
    pub fn write(&self, time: f64, out: &mut Locals) {
        for timeline in &self.timelines {
            timeline.write(time, out);
        }
    }
}

/// Whether a sampler has what its path needs.
fn is_whole(sampler: &Sampler, path: Path) -> bool {
    let width = match path {
        Path::Translation | Path::Scale => 3,
        Path::Rotation => 4,
        Path::Weights => 0,
    };
    let rows = rows_of_key(sampler.interpolation);
    let needed = sampler.times.len().checked_mul(rows).and_then(|rows| rows.checked_mul(sampler.width));
    !sampler.times.is_empty() && sampler.width >= width && needed.is_some_and(|needed| sampler.values.len() >= needed)
}

fn rows_of_key(interpolation: Interpolation) -> usize {
    if interpolation == Interpolation::CubicSpline { 3 } else { 1 }
}

/// Curves that share key times and interpolation, before their keys are laid side by side.
struct Members<'a> {
    like: &'a Sampler,
    channels: Vec<&'a Channel>,
    /// Curve, component of its values, slot.
    weights: Vec<(&'a Sampler, usize, u32)>,
}

impl<'a> Members<'a> {
    /// Those that a sampler belongs to.
    fn like<'s>(sorted: &'s mut Vec<Self>, sampler: &'a Sampler) -> &'s mut Self {
        let same =
            |members: &Self| members.like.interpolation == sampler.interpolation && members.like.times == sampler.times;
        let index = sorted.iter().position(same).unwrap_or_else(|| {
            sorted.push(Self { like: sampler, channels: Vec::new(), weights: Vec::new() });
            sorted.len() - 1
        });
        &mut sorted[index]
    }

    /// Slots of the curves of a path, and their keys row by row.
    fn rows(&self, path: Path, rows: usize) -> (Vec<u32>, Vec<&'a [f32]>) {
        let curves: Vec<_> = self.channels.iter().filter(|channel| channel.path == path).collect();
        let slots = curves.iter().map(|channel| channel.node as u32).collect();
        let row = |row: usize| curves.iter().map(move |it| &it.sampler.values[row * it.sampler.width..]);
        (slots, (0..rows).flat_map(row).collect())
    }
}

impl Timeline {
    /// Lays the keys of curves side by side.
    fn of(members: &Members) -> Self {
        let Sampler { interpolation, times, .. } = members.like;
        let rows = times.len() * rows_of_key(*interpolation);
        let spline = *interpolation == Interpolation::CubicSpline;
        let (slots, keys) = members.rows(Path::Translation, rows);
        let place = |row: &[f32]| Vec3A::from_slice(row).as_dvec3();
        let translations = Group { slots, rows: keys.into_iter().map(place).collect() };
        let (slots, keys) = members.rows(Path::Scale, rows);
        let scales = Group { slots, rows: keys.into_iter().map(Vec3A::from_slice).collect() };
        let (slots, keys) = members.rows(Path::Rotation, rows);
        // Keys are made unit but for splines, whose tangents are no rotations.
        let unit = |row: &[f32]| Vec4::from_slice(row).as_dvec4().normalize_or(DVec4::W);
        let (mut arcs, mut rotations) = (Arcs::default(), Group::default());
        if *interpolation == Interpolation::Linear {
            arcs = Arcs::over(slots, keys.into_iter().map(unit).collect());
        } else {
            let rotation =
                |row: &[f32]| Quat::from_vec4(if spline { Vec4::from_slice(row) } else { unit(row).as_vec4() });
            rotations = Group { slots, rows: keys.into_iter().map(rotation).collect() };
        }
        let weight = |row: usize| members.weights.iter().map(move |(it, target, _)| it.values[row * it.width + target]);
        Self {
            interpolation: *interpolation,
            times: times.clone(),
            translations,
            scales,
            arcs,
            rotations,
            weights: Group {
                slots: members.weights.iter().map(|&(.., slot)| slot).collect(),
                rows: (0..rows).flat_map(weight).collect(),
            },
        }
    }

    fn mix(&self, time: f64) -> Option<Mix> {
        let spline = self.interpolation == Interpolation::CubicSpline;
        Some(match (locate(&self.times, time)?, self.interpolation) {
            (Moment::At(key), _) => Mix::Row(if spline { 3 * key + 1 } else { key }),
            (Moment::Between { index, .. }, Interpolation::Step) => Mix::Row(index),
            (Moment::Between { index, share, .. }, Interpolation::Linear) => Mix::Two { first: index, share },
            (Moment::Between { index, share: t, length }, Interpolation::CubicSpline) => {
                let (t2, t3) = (t * t, t * t * t);
                let weights =
                    [2.0 * t3 - 3.0 * t2 + 1.0, length * (t3 - 2.0 * t2 + t), length * (t3 - t2), 3.0 * t2 - 2.0 * t3];
                let first = 3 * index;
                Mix::Four { rows: [first + 1, first + 2, first + 3, first + 4], weights }
            }
        })
    }

    fn write(&self, time: f64, out: &mut Locals) {
        let Some(mix) = self.mix(time) else { return };
        self.translations.write(mix, &mut out.translations, |value| value);
        self.scales.write(mix, &mut out.scales, |value| value);
        self.arcs.write(mix, &mut out.rotations);
        // In f64, so that no finite f32 over- or underflows.
        let unit = |rotation: Quat| Quat::from_vec4(Vec4::from(rotation).as_dvec4().normalize_or(DVec4::W).as_vec4());
        self.rotations.write(mix, &mut out.rotations, unit);
        self.weights.write(mix, &mut out.weights, |value| value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sine_is_good_up_to_a_quarter_turn() {
        for step in 1..=1000 {
            let x = FRAC_PI_2 * f64::from(step) / 1000.0;
            let error = f64::from(sinc(Vec4::splat((x * x) as f32)).x) - x.sin() / x;
            assert!(error.abs() < 1.2e-7, "{x}: {error:e}");
        }
    }
}
