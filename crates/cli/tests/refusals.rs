//! Bad input ends with status 2 and a message that says what, where and what to do.

mod common;

use std::fs;

use common::{asset, folder, names, refuses};

#[test]
fn files_that_are_not_there_or_not_models() {
    let (_guard, folder) = folder();
    refuses(&folder, &["export", "nowhere.glb", "-o", "a.png"], &["nowhere.glb", "check the path"]);
    refuses(&folder, &["export", "nowhere.ron", "-o", "a.png"], &["nowhere.ron", "check the path"]);
    refuses(&folder, &["export", "fox.obj", "-o", "a.png"], &["fox.obj", ".glb", ".ron"]);
    refuses(&folder, &["inspect", "nowhere.glb"], &["nowhere.glb"]);
    refuses(&folder, &["pose", "nowhere.glb"], &["nowhere.glb"]);

    let whole = fs::read(asset("dancer.glb")).unwrap();
    fs::write(folder.join("cut.glb"), &whole[..whole.len() / 2]).unwrap();
    fs::write(folder.join("noise.glb"), [0x5a; 300]).unwrap();
    for broken in ["cut.glb", "noise.glb"] {
        for arguments in [&["inspect", broken][..], &["export", broken, "-o", "a.png"], &["pose", broken]] {
            refuses(&folder, arguments, &[broken]);
        }
    }
    fs::write(folder.join("bad.ron"), "(model: \"a.glb\", lamp: 3)").unwrap();
    refuses(&folder, &["export", "bad.ron", "-o", "a.png"], &["bad.ron", "lamp"]);
    assert_eq!(names(&folder), ["bad.ron", "cut.glb", "noise.glb"]);
}

#[test]
fn values_that_make_no_sense() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    let export = |extra: &[&str], words: &[&str]| {
        refuses(&folder, &[&["export", &dancer, "-o", "a_#.png"], extra].concat(), words);
    };
    export(&["--method", "magic"], &["magic", "sir", "dir", "newton"]);
    export(&["--caustics", "magic"], &["magic", "off", "splat"]);
    export(&["--tir", "magic"], &["magic", "pass", "clamp", "reflect"]);
    export(&["--size", "0x5"], &["--size", "512x512"]);
    export(&["--size", "big"], &["--size", "512x512"]);
    export(&["--ior", "0.5"], &["--ior", "at least 1"]);
    export(&["--ior", "nan"], &["--ior", "not finite"]);
    export(&["--frames", "5..2"], &["--frames", "5..2"]);
    export(&["--camera", "up=0,1,0"], &["eye=X,Y,Z"]);
    export(&["--light", "sun"], &["spot, point, directional or model"]);
    export(&["--light", "model"], &["has no light"]);
    export(&["--camera", "model=front"], &["no camera `front`"]);
    export(&["--layer", "weight=1"], &["clip=NAME|INDEX"]);
    export(&["--layer", "clip=0,mask=fin"], &["no node `fin`", "choose one of"]);
    export(&["--skinning", "cubic"], &["linear or dual-quaternion"]);
    export(&["--variant", "night"], &["no material variant", "night"]);
    export(&["--repeat", "twice"], &["ping-pong"]);
    export(&["--clip", "swim"], &["swim", "choose one of"]);
    export(&["--env", "nowhere.hdr"], &["nowhere.hdr"]);
    export(&["--aov", "p1,p3"], &["p3", "exit_direction"]);
    export(&["--adapter", "abacus"], &["abacus", "murano adapters"]);
    export(&["--no-skip", "--verify-skips"], &["--verify-skips"]);
    assert!(names(&folder).is_empty(), "{:?}", names(&folder));
}

#[test]
fn places_that_cannot_be_written_to() {
    let (_guard, folder) = folder();
    let dancer = asset("dancer.glb");
    fs::write(folder.join("file"), "").unwrap();
    refuses(&folder, &["export", &dancer, "-o", "file/a_#.png"], &["file", "choose another place"]);
    refuses(&folder, &["pose", &dancer, "-o", "file/a.ply"], &["file", "choose another place"]);
    refuses(&folder, &["export", &dancer, "-o", "a.jpg"], &["a.jpg", ".png or .exr"]);
    refuses(&folder, &["export", &dancer, "-o", "a.png", "--frames", "0..2"], &["overwrite", "####"]);
    refuses(&folder, &["export", &dancer, "-o", "#_#.png"], &["more than one place"]);
    refuses(&folder, &["export", &dancer], &["-o out/frame_####.png"]);
    assert_eq!(names(&folder), ["file"]);
}
