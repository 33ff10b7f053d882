//! One device, many threads: whatever they render at once, each finds what it would have found alone.

use glam::Vec4;

use crate::harness::{Random, run};

/// Each thread's colours turn up in the others' plans at the same moment: inputs are uploaded by several threads at once,
/// outputs found by others before their own are done, and the buffers of all come from one store.
#[test]
fn threads_do_not_disturb_each_other() {
    let mut random = Random(70);
    let rounds: Vec<Vec<Vec4>> =
        (0..200).map(|_| (0..256).map(|_| random.in_cube().abs().extend(1.0)).collect()).collect();
    let together = std::sync::Barrier::new(4);
    let found: Vec<Vec<Vec<Vec<Vec4>>>> = std::thread::scope(|scope| {
        let work = || {
            let round = |colors: &Vec<Vec4>| {
                together.wait();
                run("tests::tone_map", "main", colors, colors.len(), 4)
            };
            rounds.iter().map(round).collect()
        };
        let threads: Vec<_> = (0..4).map(|_| scope.spawn(work)).collect();
        threads.into_iter().map(|thread| thread.join().expect("a thread")).collect()
    });
    let alone = |colors: &Vec<Vec4>| {
        // Other inputs by their stamp, the same results.
        let mut longer = colors.clone();
        longer.push(Vec4::ONE);
        let mut rows = run("tests::tone_map", "main", &longer, longer.len(), 4);
        rows.pop();
        rows
    };
    for (round, colors) in rounds.iter().enumerate() {
        let wanted = alone(colors);
        for thread in &found {
            assert!(thread[round] == wanted, "round {round}");
        }
    }
}
