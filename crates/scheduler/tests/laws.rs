//! What holds for every plan, whatever happened before: random frames, random edits, random evictions.

mod toy;

use std::collections::HashSet;

use murano_scheduler::{Decision, Reason, Skipping};
use proptest::{prelude::*, sample::Index};
use toy::{INPUT_NAMES, Store, Toy, ToyPass, executed};

/// One thing that may happen between two frames. Indices choose among whatever the frame has.
#[derive(Clone, Debug)]
enum Edit {
    Leaf(Index, u8),
    Code(Index, u8),
    Gain(Index, u8),
    Extent(Index, Index, u8),
    Rewire(Index, Index, Index),
    Target(Index),
    Evict(Vec<Index>),
    EvictAll,
}

fn edit() -> impl Strategy<Value = Edit> {
    // Few different values, so that frames come back to where they were.
    let value = 0u8..3;
    prop_oneof![
        (any::<Index>(), value.clone()).prop_map(|(leaf, value)| Edit::Leaf(leaf, value)),
        (any::<Index>(), value.clone()).prop_map(|(pass, value)| Edit::Code(pass, value)),
        (any::<Index>(), value.clone()).prop_map(|(pass, value)| Edit::Gain(pass, value)),
        (any::<Index>(), any::<Index>(), value).prop_map(|(pass, slot, value)| Edit::Extent(pass, slot, value)),
        (any::<Index>(), any::<Index>(), any::<Index>()).prop_map(|(pass, input, to)| Edit::Rewire(pass, input, to)),
        any::<Index>().prop_map(Edit::Target),
        prop::collection::vec(any::<Index>(), 1..6).prop_map(Edit::Evict),
        Just(Edit::EvictAll),
    ]
}

fn skipping() -> impl Strategy<Value = Skipping> {
    prop_oneof![4 => Just(Skipping::On), 1 => Just(Skipping::Off), 1 => Just(Skipping::Verify)]
}

/// A frame of up to 5 leaves and 12 passes; most passes are on a path to the target, some are not.
fn toy() -> impl Strategy<Value = Toy> {
    let pass = (prop::collection::vec(0u8..3, 1..4), prop::collection::vec(any::<Index>(), 0..=INPUT_NAMES.len()));
    (prop::collection::vec(0u8..3, 1..6), prop::collection::vec(pass, 1..13), any::<Index>()).prop_map(
        |(leaves, passes, target)| {
            let mut toy = Toy { leaves, passes: Vec::new(), targets: Vec::new() };
            for (extents, inputs) in passes {
                let sources = toy.sources_before(toy.passes.len());
                let inputs = inputs.iter().map(|input| input.index(sources)).collect();
                toy.passes.push(ToyPass { code: 0, gain: 0, extents, inputs });
            }
            let sources = toy.sources_before(toy.passes.len());
            // The later half, so that there is something behind it.
            toy.targets = vec![sources / 2 + target.index(sources - sources / 2)];
            toy
        },
    )
}

fn apply(toy: &mut Toy, store: &mut Store, edit: &Edit) {
    let passes = toy.passes.len();
    match edit {
        Edit::Leaf(leaf, value) => {
            let leaf = leaf.index(toy.leaves.len());
            toy.leaves[leaf] = *value;
        }
        Edit::Code(pass, value) => toy.passes[pass.index(passes)].code = *value,
        Edit::Gain(pass, value) => toy.passes[pass.index(passes)].gain = *value,
        Edit::Extent(pass, slot, value) => *slot.get_mut(&mut toy.passes[pass.index(passes)].extents) = *value,
        Edit::Rewire(pass, input, to) => {
            let pass = pass.index(passes);
            let to = to.index(toy.sources_before(pass));
            let inputs = &mut toy.passes[pass].inputs;
            if !inputs.is_empty() {
                *input.get_mut(inputs) = to;
            }
        }
        Edit::Target(target) => toy.targets = vec![target.index(toy.sources_before(passes))],
        Edit::Evict(victims) => {
            for victim in victims {
                let mut stamps: Vec<_> = store.contents.keys().copied().collect();
                stamps.sort_unstable();
                if !stamps.is_empty() {
                    store.contents.remove(victim.get(&stamps));
                }
            }
        }
        Edit::EvictAll => store.contents.clear(),
    }
}

/// Adds one to something that one pass declares; returns what a reason has to call it.
fn change_declaration(pass: &mut ToyPass, which: usize) -> &'static str {
    match which {
        0 => {
            pass.code += 1;
            "shader"
        }
        1 => {
            pass.gain += 1;
            "gain"
        }
        _ => {
            pass.extents[0] += 1;
            "extent"
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn warm_equals_cold(mut toy in toy(), frames in prop::collection::vec((edit(), skipping()), 1..40)) {
        let mut store = Store::default();
        for (edit, skipping) in frames {
            apply(&mut toy, &mut store, &edit);
            let (_, warm) = toy.run(&mut store, skipping);
            let (_, cold) = toy.run(&mut Store::default(), Skipping::On);
            prop_assert_eq!(&warm, &cold);
            prop_assert_eq!(&warm, &toy.truth());
        }
    }

    #[test]
    fn a_change_reaches_every_downstream_stamp_and_no_other(toy in toy(), pass in any::<Index>(), which in 0usize..3) {
        let mut changed = toy.clone();
        let pass = pass.index(toy.passes.len());
        change_declaration(&mut changed.passes[pass], which);
        let (_, before) = toy.plan();
        let (_, after) = changed.plan();
        let downstream = toy.downstream(|source| toy.producer(source) == Some(pass));
        for source in 0..before.len() {
            prop_assert_eq!(before[source].stamp() != after[source].stamp(), downstream.contains(&source));
        }
    }

    #[test]
    fn a_leaf_reaches_every_downstream_stamp_and_no_other(toy in toy(), leaf in any::<Index>()) {
        let mut changed = toy.clone();
        let leaf = leaf.index(toy.leaves.len());
        changed.leaves[leaf] += 1;
        let (_, before) = toy.plan();
        let (_, after) = changed.plan();
        let downstream = toy.downstream(|source| source == leaf);
        for source in 0..before.len() {
            prop_assert_eq!(before[source].stamp() != after[source].stamp(), downstream.contains(&source));
        }
    }

    #[test]
    fn repeating_a_frame_runs_nothing(toy in toy()) {
        let mut store = Store::default();
        toy.run(&mut store, Skipping::On);
        let (schedule, _) = toy.run(&mut store, Skipping::On);
        prop_assert!(executed(&schedule).is_empty());
        prop_assert!(schedule.leaves.is_empty());
    }

    #[test]
    fn coming_back_runs_nothing(mut toy in toy(), edits in prop::collection::vec(edit(), 1..10)) {
        let mut store = Store::default();
        let start = toy.clone();
        start.run(&mut store, Skipping::On);
        for edit in edits.iter().filter(|edit| !matches!(edit, Edit::Evict(_) | Edit::EvictAll)) {
            apply(&mut toy, &mut store, edit);
            toy.run(&mut store, Skipping::On);
        }
        let (schedule, _) = start.run(&mut store, Skipping::On);
        prop_assert!(executed(&schedule).is_empty());
    }

    #[test]
    fn a_red_herring_runs_nothing(mut toy in toy()) {
        let mut store = Store::default();
        toy.run(&mut store, Skipping::On);
        let reached = toy.reached();
        let read: HashSet<usize> =
            reached.iter().flat_map(|&pass| toy.passes[pass].inputs.clone()).chain(toy.targets.clone()).collect();
        for leaf in (0..toy.leaves.len()).filter(|leaf| !read.contains(leaf)) {
            toy.leaves[leaf] += 1;
        }
        for pass in (0..toy.passes.len()).filter(|pass| !reached.contains(pass)) {
            toy.passes[pass].gain += 1;
        }
        let (schedule, _) = toy.run(&mut store, Skipping::On);
        prop_assert!(executed(&schedule).is_empty());
        prop_assert!(schedule.leaves.is_empty());
    }

    #[test]
    fn exactly_what_is_not_on_a_path_is_culled(toy in toy(), skipping in skipping()) {
        let (schedule, _) = toy.run(&mut Store::default(), skipping);
        for step in &schedule.steps {
            let culled = matches!(step.decision, Decision::Culled(_));
            prop_assert_eq!(culled, !toy.reached().contains(&(step.instance as usize)));
        }
    }

    #[test]
    fn nothing_runs_without_need(mut toy in toy(), edits in prop::collection::vec(edit(), 1..20)) {
        let mut store = Store::default();
        for edit in edits {
            apply(&mut toy, &mut store, &edit);
            let held: HashSet<_> = store.contents.keys().copied().collect();
            let (schedule, _) = toy.run(&mut store, Skipping::On);
            let ran = executed(&schedule);
            let read: HashSet<usize> =
                ran.iter().flat_map(|&pass| toy.passes[pass].inputs.clone()).chain(toy.targets.clone()).collect();
            let (_, outputs) = toy.plan();
            for pass in ran {
                let first = toy.sources_before(pass);
                let slots = first..first + toy.passes[pass].extents.len();
                prop_assert!(slots.into_iter().any(|slot| read.contains(&slot) && !held.contains(&outputs[slot].stamp())));
            }
        }
    }

    #[test]
    fn off_runs_every_reached_pass(mut toy in toy(), edits in prop::collection::vec(edit(), 0..10)) {
        let mut store = Store::default();
        for edit in edits {
            apply(&mut toy, &mut store, &edit);
        }
        toy.run(&mut store, Skipping::On);
        let (schedule, _) = toy.run(&mut store, Skipping::Off);
        prop_assert_eq!(executed(&schedule), toy.reached());
        for step in schedule.steps.iter().filter(|step| step.executes()) {
            prop_assert_eq!(step.decision, Decision::Ran(Reason::Forced));
            prop_assert!(!step.verify);
        }
    }

    #[test]
    fn verify_compares_exactly_what_is_resident(toy in toy(), evicted in prop::collection::vec(any::<Index>(), 0..6)) {
        let mut store = Store::default();
        let (_, cold) = toy.run(&mut store, Skipping::On);
        apply(&mut toy.clone(), &mut store, &Edit::Evict(evicted));
        let held: HashSet<_> = store.contents.keys().copied().collect();
        let reached = toy.reached();
        let read: HashSet<usize> =
            reached.iter().flat_map(|&pass| toy.passes[pass].inputs.clone()).chain(toy.targets.clone()).collect();
        let (_, outputs) = toy.plan();

        let (schedule, warm) = toy.run(&mut store, Skipping::Verify);
        prop_assert_eq!(warm, cold);
        prop_assert_eq!(executed(&schedule), reached.clone());
        for step in &schedule.steps {
            let pass = step.instance as usize;
            let first = toy.sources_before(pass);
            let resident = (first..first + toy.passes[pass].extents.len())
                .filter(|slot| read.contains(slot))
                .all(|slot| held.contains(&outputs[slot].stamp()));
            prop_assert_eq!(step.verify, reached.contains(&pass) && resident);
            prop_assert!(!step.verify || step.decision == Decision::Reused);
        }
    }

    #[test]
    fn reasons_name_what_differs(toy in toy(), pass in any::<Index>(), which in 0usize..3) {
        let mut store = Store::default();
        let (first, _) = toy.run(&mut store, Skipping::On);
        for step in first.steps.iter().filter(|step| step.executes()) {
            prop_assert_eq!(step.decision, Decision::Ran(Reason::FirstRun));
        }

        let mut changed = toy.clone();
        let edited = pass.index(toy.passes.len());
        let label = change_declaration(&mut changed.passes[edited], which);
        let downstream = toy.downstream(|source| toy.producer(source) == Some(edited));
        let (schedule, _) = changed.run(&mut store, Skipping::On);
        for step in schedule.steps.iter().filter(|step| step.executes()) {
            let pass = step.instance as usize;
            let changed_input = || {
                let position = toy.passes[pass].inputs.iter().position(|input| downstream.contains(input));
                position.map(|position| INPUT_NAMES[position])
            };
            let expected = if pass == edited { Some(label) } else { changed_input() };
            prop_assert_eq!(Some(step.decision), expected.map(|name| Decision::Ran(Reason::Changed(name))));
        }
    }
}
