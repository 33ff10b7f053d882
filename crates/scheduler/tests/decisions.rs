//! The frame of the crate's own diagram, case by case, and the errors of planning.

use std::{
    collections::HashSet,
    time::{Duration, Instant},
};

use murano_scheduler::{Decision, History, Output, Pass, Plan, PlanError, Reason, Schedule, Skipping, Stamp};

const FIRST_RUN: Decision = Decision::Ran(Reason::FirstRun);
const EVICTED: Decision = Decision::Ran(Reason::Evicted);
const FORCED: Decision = Decision::Ran(Reason::Forced);
const REUSED: Decision = Decision::Reused;

fn changed(name: &'static str) -> Decision {
    Decision::Ran(Reason::Changed(name))
}

/// Decisions on `bend`, `shine` and `shoot`.
fn decisions(schedule: &Schedule) -> [Decision; 3] {
    ["bend", "shine", "shoot"].map(|name| schedule.decision(name, 0).expect("declared in every frame"))
}

/// A pass without parameters.
fn pass(name: &'static str, inputs: Vec<(&'static str, Output)>) -> Pass<()> {
    Pass {
        name,
        instance: 0,
        subject: 0,
        code: Stamp::of(name.as_bytes()),
        params: vec![],
        inputs,
        outputs: vec![("out", vec![])],
        work: (),
    }
}

/// What a session of frames keeps.
#[derive(Default)]
struct Session {
    resident: HashSet<Stamp>,
    history: History,
}

#[derive(Clone, Copy, Default)]
struct Frame {
    weights: u8,
    lens: u8,
    sun: u8,
}

impl Session {
    fn resolve(&mut self, plan: &Plan<()>, targets: &[Output], skipping: Skipping) -> Schedule {
        let schedule = plan
            .resolve(targets, |stamp| self.resident.contains(&stamp), &mut self.history, skipping)
            .expect("targets are the plan's");
        self.resident.extend(schedule.leaves.iter().map(|leaf| leaf.stamp));
        self.resident.extend(schedule.executed().flat_map(|(_, step)| step.outputs.to_vec()));
        schedule
    }

    fn show(&mut self, frame: Frame, skipping: Skipping) -> Schedule {
        let (plan, bend, shoot) = frame.plan();
        drop(bend);
        self.resolve(&plan, &[shoot], skipping)
    }
}

impl Frame {
    /// The plan, the output of `bend` and the target.
    fn plan(self) -> (Plan<()>, Vec<Output>, Output) {
        let mut plan = Plan::new();
        let mut leaf = |name, value| plan.leaf(name, Stamp::of(&[value]), ());
        let (weights, lens, sun) = (leaf("weights", self.weights), leaf("lens", self.lens), leaf("sun", self.sun));
        let bend = plan.add(pass("bend", vec![("weights", weights)])).expect("new");
        let shine = plan.add(pass("shine", vec![("sun", sun)])).expect("new");
        let shoot = plan.add(pass("shoot", vec![("body", bend[0]), ("lens", lens), ("light", shine[0])])).expect("new");
        (plan, bend, shoot[0])
    }
}

#[test]
fn the_lens_leaves_everything_else_alone() {
    let mut session = Session::default();
    let first = session.show(Frame::default(), Skipping::On);
    assert_eq!(decisions(&first), [FIRST_RUN; 3]);
    assert_eq!(first.leaves.len(), 3);

    let second = session.show(Frame { lens: 1, ..Frame::default() }, Skipping::On);
    assert_eq!(decisions(&second), [REUSED, REUSED, changed("lens")]);
    assert_eq!(second.leaves.iter().map(|leaf| leaf.name).collect::<Vec<_>>(), ["lens"]);

    let back = session.show(Frame::default(), Skipping::On);
    assert_eq!(back.executed().count(), 0);

    let third = session.show(Frame { sun: 1, ..Frame::default() }, Skipping::On);
    assert_eq!(decisions(&third), [REUSED, changed("sun"), changed("light")]);
}

#[test]
fn what_lies_behind_a_reused_pass_is_not_computed_even_if_evicted() {
    let mut session = Session::default();
    session.show(Frame::default(), Skipping::On);
    let (_, bend, target) = Frame::default().plan();
    let all = session.resident.clone();
    session.resident.retain(|stamp| *stamp == target.stamp());
    let schedule = session.show(Frame::default(), Skipping::On);
    assert_eq!((schedule.executed().count(), schedule.leaves.len()), (0, 0));

    session.resident = all;
    session.resident.remove(&bend[0].stamp());

    assert_eq!(session.show(Frame::default(), Skipping::On).executed().count(), 0);
    session.resident.remove(&target.stamp());
    let schedule = session.show(Frame::default(), Skipping::On);
    assert_eq!(decisions(&schedule), [EVICTED, REUSED, EVICTED]);
}

#[test]
fn off_forces_what_would_be_reused_and_tells_true_reasons_of_the_rest() {
    let mut session = Session::default();
    session.show(Frame::default(), Skipping::On);
    let schedule = session.show(Frame { sun: 1, ..Frame::default() }, Skipping::Off);
    assert_eq!(decisions(&schedule), [FORCED, changed("sun"), changed("light")]);
}

#[test]
fn verify_executes_and_keeps_calling_it_reused() {
    let mut session = Session::default();
    session.show(Frame::default(), Skipping::On);
    let schedule = session.show(Frame { lens: 1, ..Frame::default() }, Skipping::Verify);
    assert_eq!(decisions(&schedule), [REUSED, REUSED, changed("lens")]);
    assert_eq!(schedule.steps.iter().map(|step| step.verify).collect::<Vec<_>>(), [true, true, false]);
    assert_eq!(schedule.executed().count(), 3);
}

#[test]
fn a_slot_nobody_reads_need_not_be_resident() {
    let mut session = Session::default();
    let mut plan = Plan::new();
    let mut two = pass("two", vec![]);
    two.outputs.push(("spare", vec![]));
    let slots = plan.add(two).expect("new");
    session.resolve(&plan, &slots[..1], Skipping::On);
    session.resident.remove(&slots[1].stamp());
    assert_eq!(session.resolve(&plan, &slots[..1], Skipping::On).decision("two", 0), Some(REUSED));
    assert_eq!(session.resolve(&plan, &slots, Skipping::On).decision("two", 0), Some(EVICTED));
}

#[test]
fn equal_leaves_are_materialised_once_and_a_leaf_can_be_the_target() {
    let mut plan = Plan::new();
    let content = Stamp::of(b"sky");
    let targets = [plan.leaf("sky", content, ()), plan.leaf("sky", content, ()), plan.leaf("other sky", content, ())];
    let mut session = Session::default();
    assert_eq!(session.resolve(&plan, &targets, Skipping::On).leaves.len(), 2);
    assert!(session.resolve(&plan, &targets, Skipping::Verify).leaves.is_empty());
}

#[test]
fn reasons_name_inputs_that_come_and_go() {
    let mut session = Session::default();
    let mut show = |names: &[&'static str]| {
        let mut plan = Plan::new();
        let inputs = names.iter().map(|&name| (name, plan.leaf("leaf", Stamp::of(b"same"), ()))).collect();
        let target = plan.add(pass("mix", inputs)).expect("new");
        session.resolve(&plan, &target, Skipping::On).decision("mix", 0).expect("declared")
    };
    assert_eq!(show(&["floor", "sky"]), FIRST_RUN);
    assert_eq!(show(&["floor", "fog", "sky"]), changed("fog"));
    assert_eq!(show(&["fog", "sky"]), changed("floor"));
    assert_eq!(show(&["fog"]), changed("sky"));
    assert_eq!(show(&["fog", "rain"]), changed("rain"));
}

#[test]
fn the_table_shows_every_pass_with_its_reason() {
    let mut session = Session::default();
    session.show(Frame::default(), Skipping::On);
    let mut plan = Plan::new();
    let weights = plan.leaf("weights", Stamp::of(&[1]), ());
    plan.cull("shine", 0, "no light").expect("new");
    plan.add(pass("stray", vec![])).expect("new");
    let bend = plan.add(pass("bend", vec![("weights", weights)])).expect("new");
    plan.cull("shoot", 0, "the lens is closed").expect("new");
    let schedule = session.resolve(&plan, &bend, Skipping::On);
    let table = "\
shine:0  culled  no light
stray:0  culled  nothing shown needs it
bend:0   ran     weights changed
shoot:0  culled  the lens is closed
weights  leaf
";
    assert_eq!(schedule.to_string(), table);
    assert_eq!(
        schedule.decision("shoot", 0).map(|decision| decision.to_string()).as_deref(),
        Some("culled: the lens is closed")
    );
    assert_eq!(schedule.decision("bend", 7), None);
}

#[test]
fn misuse_is_an_error_that_leaves_the_plan_as_it_was() {
    let mut plan = Plan::new();
    let own = plan.add(pass("bend", vec![])).expect("new");
    let duplicate = PlanError::Duplicate { name: "bend", instance: 0 };
    assert_eq!(plan.add(pass("bend", vec![])).err(), Some(duplicate.clone()));
    assert_eq!(plan.cull("bend", 0, "why not").err(), Some(duplicate));

    let mut other = Plan::new();
    let stranger = other.add(pass("stranger", vec![])).expect("new");
    let foreign = PlanError::ForeignInput { name: "shoot", instance: 0, input: "body" };
    assert_eq!(plan.add(pass("shoot", vec![("body", stranger[0])])).err(), Some(foreign));
    let outcome = plan.resolve(&[own[0], stranger[0]], |_| false, &mut History::new(), Skipping::On);
    assert_eq!(outcome.err(), Some(PlanError::ForeignTarget { position: 1 }));

    plan.add(pass("shoot", vec![("body", own[0])])).expect("the failed declaration took no name");
}

/// A chain of 1000 passes with two parameters and two slots each, all reused.
#[test]
fn a_thousand_passes_take_little_time() {
    let build = || {
        let mut plan = Plan::new();
        let mut last = plan.leaf("start", Stamp::of(&[0]), ());
        for instance in 0..1000 {
            let mut link = pass("link", vec![("previous", last)]);
            link.instance = instance;
            link.params = vec![("camera", vec![0; 64]), ("size", vec![0; 8])];
            link.outputs.push(("second", vec![]));
            last = plan.add(link).expect("new")[0];
        }
        (plan, last)
    };
    let mut session = Session::default();
    let (plan, target) = build();
    session.resolve(&plan, &[target], Skipping::On);

    let mut fastest = [Duration::MAX; 2];
    for _ in 0..20 {
        let start = Instant::now();
        let (plan, target) = build();
        let declared = start.elapsed();
        let start = Instant::now();
        let schedule = session.resolve(&plan, &[target], Skipping::On);
        let resolved = start.elapsed();
        assert_eq!(schedule.executed().count(), 0);
        fastest = [fastest[0].min(declared), fastest[1].min(resolved)];
    }
    println!("1000 passes: declared in {:?}, resolved in {:?}", fastest[0], fastest[1]);
    // Two orders of magnitude above what a laptop takes: only a change of complexity fails.
    assert!(fastest[0] + fastest[1] < Duration::from_millis(200));
}

/// A pass about another moment finds what the pass it is about has left, and is that pass where both moments are the same.
#[test]
fn another_moment_finds_what_was_left() {
    let mut session = Session::default();
    let mut frame = |now: u8, before: u8| {
        let mut plan: Plan<()> = Plan::new();
        let [now, before] = [now, before].map(|weights| plan.leaf("weights", Stamp::of(&[weights]), ()));
        let moving = plan.add(pass("bend", vec![("weights", now)])).expect("legal");
        let earlier = Pass { instance: 1, subject: 0, ..pass("bend", vec![("weights", before)]) };
        let earlier = plan.add(earlier).expect("legal");
        let targets = [moving[0], earlier[0]];
        let resident = &session.resident;
        let schedule = plan
            .resolve(&targets, |stamp| resident.contains(&stamp), &mut session.history, Skipping::On)
            .expect("the plan's own outputs");
        session.resident.extend(targets.map(Output::stamp));
        let ran = schedule.steps.iter().filter(|step| matches!(step.decision, Decision::Ran(_))).count();
        (schedule.steps.len(), ran, targets[0] == targets[1])
    };
    assert_eq!(frame(1, 0), (2, 2, false));
    assert_eq!(frame(2, 1), (2, 1, false));
    assert_eq!(frame(2, 2), (1, 0, true));
    assert_eq!(frame(1, 2), (2, 0, false));
}

#[test]
fn what_a_round_repeats_is_the_pass_before() {
    let mut plan = Plan::new();
    let sun = plan.add(pass("sun", vec![])).expect("new")[0];
    let shot = plan.add(pass("shoot", vec![("sun", sun)])).expect("new")[0];
    plan.next_round();
    let same = plan.add(pass("sun", vec![])).expect("the same")[0];
    assert_eq!(same, sun);
    let other = Pass { params: vec![("lens", vec![1])], ..pass("shoot", vec![("sun", same)]) };
    let other = plan.add(other).expect("another round")[0];
    assert_ne!(other, shot);
    let twice = Pass { params: vec![("lens", vec![2])], ..pass("shoot", vec![("sun", same)]) };
    assert_eq!(plan.add(twice).map(|_| ()), Err(PlanError::Duplicate { name: "shoot", instance: 0 }));
    let schedule = Session::default().resolve(&plan, &[shot, other], Skipping::On);
    let steps: Vec<_> = schedule.executed().map(|(_, step)| (step.name, step.round)).collect();
    assert_eq!(steps, [("sun", 0), ("shoot", 0), ("shoot", 1)]);
    assert!(schedule.to_string().contains("shoot:0.1"), "{schedule}");
}
