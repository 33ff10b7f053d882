//! The frame scheduler: decides, from content alone, what of a frame has to be computed.
//!
//! # The idea
//!
//! A frame is declared as a [`Plan`]: *leaves* are data given by value (matrices, vertices, an image), *passes* are
//! pure functions from named inputs and parameters to named output slots. Nothing is executed while declaring; the
//! scheduler does not know what a pass does, nor on what device.
//!
//! ```text
//!              leaf         leaf        leaf
//!             weights       lens        sun
//!                |            |          |
//!                v            |          v
//!             +------+        |      +-------+
//!             | bend |--------)----->| shine |      key(shine)   = hash(name, subject, code, parameters,
//!             +------+        |      +-------+                          extents, stamps of named inputs)
//!                |            v          |          stamp(output) = hash(key, slot)
//!                |        +-------+      |
//!                +------->| shoot |<-----+
//!                         +-------+
//!                             |
//!                          target
//! ```
//!
//! Every output carries a [`Stamp`], the hash of everything that can influence its content, transitively. Two outputs
//! with equal stamps hold equal bits, whenever and however often they were computed. That one fact replaces dirty
//! flags, frame counters and invalidation rules: a paused clip, a light that moved and came back, scrubbing to an
//! instant still in memory are all the same case, *the stamp is resident*. And what is not among the inputs of a pass
//! cannot make it run: above, changing the lens leaves `bend` and `shine` alone.
//!
//! # Deciding
//!
//! [`Plan::resolve`] walks from the targets towards the leaves and gives every pass one [`Decision`]:
//!
//! ```text
//!   declared culled by the caller, or no path to a target .................. Culled(why)
//!   a target or a running pass reads an output that is not resident ........ Ran(why)
//!   otherwise: its outputs are resident, or only reused passes read them ... Reused
//! ```
//!
//! A reused pass demands nothing, so whatever lies behind it is not computed either, not even if it was evicted. The
//! reason of a `Ran` names the first thing that differs from the last frame in which the pass mattered; the
//! [`History`] remembers those. It explains decisions and never makes them: residency alone does.
//!
//! [`Skipping::Off`] runs every pass on a path to a target. [`Skipping::Verify`] also executes what would be reused, so that
//! the executor can compare bits: the law behind everything here is that **a warm frame equals a cold frame, bit for
//! bit**, and it holds as long as passes are pure functions of what they declare.
//!
//! The resulting [`Schedule`] is a value: an executor runs it, a test asserts it without a device, and its `Display` is
//! a table for people.

mod history;
mod plan;
mod resolve;
mod schedule;
mod stamp;

pub use history::History;
pub use plan::{Leaf, LeafIndex, Output, Pass, PassIndex, Plan, PlanError};
pub use resolve::Skipping;
pub use schedule::{Decision, MissingLeaf, Reason, Schedule, Step};
pub use stamp::{Stamp, StampBuilder};
