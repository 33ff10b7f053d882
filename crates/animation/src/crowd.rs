//! Many characters of one rig and one geometry: posed in parallel, and only those that changed.

use glam::{DMat4, DVec3};
use murano_gpu::Leaf;
use rayon::prelude::*;

use crate::deform::PoseLeaves;
use crate::geometry::Geometry;
use crate::layer::Layer;
use crate::palette::PaletteRow;
use crate::pose::Pose;
use crate::rig::{Rig, Workspace};
use crate::targets::{ActiveRange, ActiveTarget};

/// Characters that are deformed by one dispatch. One that moves takes its block along.
pub const BLOCK: usize = 32;

/// What one character does, and where.
#[derive(Debug, PartialEq)]
pub struct Character {
    /// What it plays.
    pub playing: Vec<Layer>,
    /// `world_from_root`: every root of the scene hangs on this.
    pub place: DMat4,
}

impl Clone for Character {
    fn clone(&self) -> Self {
        Self { playing: self.playing.clone(), place: self.place }
    }

    /// Without an allocation where there is room.
    fn clone_from(&mut self, source: &Self) {
        self.playing.clone_from(&source.playing);
        self.place = source.place;
    }
}

/// Up to 32 characters, as they were posed last.
pub struct Block {
    shown: Vec<Character>,
    palette: Vec<PaletteRow>,
    /// Of every character.
    targets: Vec<(Vec<ActiveTarget>, Vec<ActiveRange>)>,
    pub(crate) leaves: PoseLeaves,
}

impl Block {
    /// Characters in it.
    pub fn len(&self) -> usize {
        self.shown.len()
    }

    /// Whether nobody is in it.
    pub fn is_empty(&self) -> bool {
        self.shown.is_empty()
    }

    /// [`Geometry::palette`] of its characters, one after the other.
    pub fn palette(&self) -> &[PaletteRow] {
        &self.palette
    }

    fn new(characters: usize, palette_rows: usize) -> Self {
        Self {
            shown: Vec::with_capacity(characters),
            palette: vec![PaletteRow::default(); characters * palette_rows],
            targets: vec![(Vec::new(), Vec::new()); characters],
            leaves: PoseLeaves {
                palette: Leaf::of::<PaletteRow>(&[]),
                active_targets: Leaf::of::<ActiveTarget>(&[]),
                active_ranges: Leaf::of::<ActiveRange>(&[]),
            },
        }
    }

    /// Poses those that changed; returns how many.
    fn update(&mut self, characters: &[Character], origin: Option<DVec3>, posing: &mut Posing) -> usize {
        let mut posed = 0;
        for (index, character) in characters.iter().enumerate() {
            if origin.is_none() && self.shown.get(index) == Some(character) {
                continue;
            }
            posing.pose(character, &mut self.palette, &mut self.targets, index);
            match self.shown.get_mut(index) {
                Some(shown) => shown.clone_from(character),
                None => self.shown.push(character.clone()),
            }
            posed += 1;
        }
        if posed > 0 {
            self.leaves = self.upload();
        }
        posed
    }

    fn upload(&self) -> PoseLeaves {
        let mut all: Vec<ActiveTarget> = Vec::new();
        let mut all_ranges: Vec<ActiveRange> = Vec::new();
        for (targets, ranges) in &self.targets {
            let before = all.len() as u32;
            all.extend(targets);
            let moved =
                |range: &ActiveRange| ActiveRange { start: range.start + before, end: range.end + before, ..*range };
            all_ranges.extend(ranges.iter().map(moved));
        }
        PoseLeaves {
            palette: Leaf::of(&self.palette),
            active_targets: Leaf::of(&all),
            active_ranges: Leaf::of(&all_ranges),
        }
    }
}

/// What a thread needs to pose characters.
struct Posing<'a> {
    rig: &'a Rig,
    geometry: &'a Geometry,
    origin: DVec3,
    workspace: Workspace,
    pose: Pose,
}

impl Posing<'_> {
    fn pose(
        &mut self,
        character: &Character,
        palettes: &mut [PaletteRow],
        targets: &mut [(Vec<ActiveTarget>, Vec<ActiveRange>)],
        index: usize,
    ) {
        self.rig.pose_at(&character.playing, &character.place, &mut self.workspace, &mut self.pose);
        let len = self.geometry.palette_rows();
        self.geometry.palette_into(&self.pose, self.origin, &mut palettes[index * len..][..len]);
        let (active, ranges) = &mut targets[index];
        active.clear();
        ranges.clear();
        self.geometry.push_active_targets(&self.pose, active, ranges);
    }
}

/// Characters that share a rig and a geometry.
pub struct Crowd {
    rig: Rig,
    geometry: Geometry,
    blocks: Vec<Block>,
    origin: DVec3,
}

impl Crowd {
    /// A crowd of nobody. The geometry must be of the rig's scene.
    pub fn new(rig: Rig, geometry: Geometry) -> Self {
        Self { rig, geometry, blocks: Vec::new(), origin: DVec3::ZERO }
    }

    /// The geometry of every character.
    pub fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// Its characters by 32, ready for [`crate::GeometryLeaves::deform_block`].
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Poses the characters that are new or do something else than last time, on all cores; render space is world space less
    /// `origin`, and where that has changed, all are posed. Returns how many were.
    pub fn update(&mut self, characters: &[Character], origin: DVec3) -> usize {
        let len = self.geometry.palette_rows();
        let moved = (origin != self.origin).then_some(origin);
        self.origin = origin;
        self.blocks.truncate(characters.len().div_ceil(BLOCK));
        for (index, characters) in characters.chunks(BLOCK).enumerate() {
            // A block of another size starts anew.
            if self.blocks.get(index).is_none_or(|block| block.len() != characters.len()) {
                self.blocks.truncate(index);
                self.blocks.push(Block::new(characters.len(), len));
            }
        }
        let posing = || Posing {
            rig: &self.rig,
            geometry: &self.geometry,
            origin,
            workspace: Workspace::default(),
            pose: self.rig.rest().clone(),
        };
        let blocks = self.blocks.par_iter_mut().zip(characters.par_chunks(BLOCK));
        blocks.map_init(posing, |posing, (block, characters)| block.update(characters, moved, posing)).sum()
    }
}
