//! `--layer`: a clip laid over what plays.

use std::str::FromStr;

use murano_scene::{LoopMode, ShotLayer};

use crate::values::{clip_choice, not_negative, number};

const LOOP_MODES: [(&str, LoopMode); 4] =
    [("once", LoopMode::Once), ("loop", LoopMode::Loop), ("ping-pong", LoopMode::PingPong), ("clamp", LoopMode::Clamp)];

/// What happens outside a clip's span, by its name.
pub fn loop_mode(text: &str) -> Result<LoopMode, String> {
    let mode = LOOP_MODES.iter().find(|(name, _)| *name == text).map(|(_, mode)| *mode);
    mode.ok_or_else(|| format!("`{text}` is no way to repeat; choose once, loop, ping-pong or clamp"))
}

/// The value of `--layer`.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerOption(pub ShotLayer);

impl FromStr for LayerOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut layer = ShotLayer::default();
        let mut named = false;
        for word in text.split(',') {
            let expected = "expected clip=NAME|INDEX and, after commas, weight=W, speed=S, repeat=MODE, from=S, until=S, \
                            fade=S, blend=over|add, mask=NODE+NODE";
            match word.split_once('=').ok_or(expected)? {
                (name, "") => return Err(format!("{name}= needs a value")),
                ("clip", clip) => {
                    layer.clip = clip_choice(clip);
                    named = true;
                }
                ("weight", value) => layer.weight = number(value)?,
                ("speed", value) => layer.speed = number(value)?,
                ("repeat", mode) => layer.repeat = loop_mode(mode)?,
                ("from", value) => layer.from = number(value)?,
                ("until", value) => layer.until = Some(number(value)?),
                ("fade", value) => layer.fade = not_negative(value)?,
                ("blend", "over") => layer.add = false,
                ("blend", "add") => layer.add = true,
                ("mask", nodes) => layer.mask = nodes.split('+').map(str::to_owned).collect(),
                _ => return Err(expected.into()),
            }
        }
        if !named {
            return Err("a layer needs clip=NAME|INDEX".into());
        }
        if layer.until.is_some_and(|until| until <= layer.from) {
            return Err("until must be later than from".into());
        }
        Ok(Self(layer))
    }
}

#[cfg(test)]
mod tests {
    use murano_scene::ClipChoice;

    use super::*;

    #[test]
    fn layers_are_read() {
        let LayerOption(layer) =
            "clip=wave,weight=0.5,repeat=ping-pong,from=1,until=3,fade=0.25,blend=add,mask=arm+head".parse().unwrap();
        let wanted = ShotLayer {
            clip: ClipChoice::Name("wave".into()),
            weight: 0.5,
            repeat: LoopMode::PingPong,
            from: 1.0,
            until: Some(3.0),
            fade: 0.25,
            add: true,
            mask: vec!["arm".into(), "head".into()],
            ..ShotLayer::default()
        };
        assert_eq!(layer, wanted);
        assert_eq!("clip=2".parse::<LayerOption>().unwrap().0.clip, ClipChoice::Index(2));
        for wrong in [
            "",
            "wave",
            "weight=1",
            "clip=a,weight=x",
            "clip=a,fade=-1",
            "clip=a,until=0",
            "clip=a,blend=mix",
            "clip=",
            "clip=a,mask=",
        ] {
            assert!(wrong.parse::<LayerOption>().is_err(), "{wrong}");
        }
    }
}
