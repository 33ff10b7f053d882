use murano_animation::{Layer, Rig, Workspace};
use std::time::Instant;
fn main() {
    for file in std::env::args().skip(1) {
        let scene = murano_scene::import(file.as_ref()).unwrap();
        let rig = Rig::new(&scene);
        let joints: usize = scene.skins.iter().map(|s| s.joints.len()).sum();
        let d = scene.clips[0].duration;
        let mut w = Workspace::default();
        let mut pose = rig.rest().clone();
        let n = 20000;
        let mut run = |name: &str, f: &mut dyn FnMut(usize)| {
            let mut best = f64::INFINITY;
            for _ in 0..5 {
                let s = Instant::now();
                for k in 0..n {
                    f(k);
                }
                best = best.min(s.elapsed().as_secs_f64() * 1e6 / n as f64);
            }
            println!(
                "{file} {name}: {best:.3} us, {:.1} joints/us ({joints} joints, {} nodes)",
                joints as f64 / best,
                scene.nodes.len()
            );
        };
        run("sample forward", &mut |k| rig.sample(&[Layer::new(0, d * (k % 1000) as f64 / 1000.0)], &mut w));
        run("sample seek", &mut |k| rig.sample(&[Layer::new(0, d * ((k * 7919) % 1000) as f64 / 1000.0)], &mut w));
        let last = scene.clips.len() - 1;
        run("sample blend of 2", &mut |k| {
            let t = d * (k % 1000) as f64 / 1000.0;
            rig.sample(&[Layer::new(0, t), Layer { weight: 0.5, ..Layer::new(last, t) }], &mut w)
        });
        run("pose", &mut |k| rig.pose_into(&[Layer::new(0, d * (k % 1000) as f64 / 1000.0)], &mut w, &mut pose));
    }
}
