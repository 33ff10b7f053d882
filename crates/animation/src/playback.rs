//! From the time that passes to the time in a clip.

use murano_scene::LoopMode;

/// The time in a clip of `duration` seconds at which to sample after `time` seconds of playback, in `0..=duration` (and
/// below `duration` in [`LoopMode::Loop`]). Negative times play what came before zero. Zero where there is
/// no answer: no positive finite duration, a time that is not a number, the phase of an infinite time.
pub fn clip_time(mode: LoopMode, time: f64, duration: f64) -> f64 {
    if !duration.is_finite() || duration <= 0.0 || time.is_nan() {
        return 0.0;
    }
    match mode {
        LoopMode::Clamp => time.clamp(0.0, duration),
        LoopMode::Once if time > duration => 0.0,
        LoopMode::Once => time.max(0.0),
        LoopMode::Loop => wrapped(time, duration),
        LoopMode::PingPong => {
            // In units of the duration, whose double may not be finite.
            let phase = wrapped(time / duration, 2.0);
            duration * if phase > 1.0 { 2.0 - phase } else { phase }
        }
    }
}

/// The time in a clip of `duration` seconds that began at its time `start` and has played for `elapsed` seconds at a speed.
/// Backwards, a clip that plays once begins as far before its end.
pub fn played_time(mode: LoopMode, speed: f64, start: f64, elapsed: f64, duration: f64) -> f64 {
    let begins_at_end = speed < 0.0 && matches!(mode, LoopMode::Once | LoopMode::Clamp);
    clip_time(mode, if begins_at_end { duration - start } else { start } + speed * elapsed, duration)
}

/// The remainder in `0..period`, also where rounding lifts that of a tiny negative time to the period itself; zero for a
/// time without end.
fn wrapped(time: f64, period: f64) -> f64 {
    let phase = time.rem_euclid(period);
    if phase < period { phase } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(mode: LoopMode, times: &[f64]) -> Vec<f64> {
        times.iter().map(|&time| clip_time(mode, time, 2.0)).collect()
    }

    #[test]
    fn once_rests_at_the_start() {
        assert_eq!(times(LoopMode::Once, &[-1.0, 0.0, 1.5, 2.0, 2.5]), [0.0, 0.0, 1.5, 2.0, 0.0]);
    }

    #[test]
    fn clamp_holds_the_ends() {
        let given = [-1.0, 1.5, 2.0, 2.5, f64::INFINITY, f64::NEG_INFINITY];
        assert_eq!(times(LoopMode::Clamp, &given), [0.0, 1.5, 2.0, 2.0, 2.0, 0.0]);
    }

    #[test]
    fn a_loop_ends_where_it_starts() {
        assert_eq!(times(LoopMode::Loop, &[0.0, 1.5, 2.0, 5.0, -0.5, -4.0]), [0.0, 1.5, 0.0, 1.0, 1.5, 0.0]);
        assert_eq!(times(LoopMode::Loop, &[-1e-300]), [0.0]);
    }

    #[test]
    fn ping_pong_turns_at_both_ends() {
        let given = [0.0, 1.5, 2.0, 2.5, 4.0, 4.5, -0.5, -2.0, -3.5, -1e-300];
        assert_eq!(times(LoopMode::PingPong, &given), [0.0, 1.5, 2.0, 1.5, 0.0, 0.5, 0.5, 2.0, 0.5, 0.0]);
    }

    #[test]
    fn backwards_a_clip_begins_at_its_end_where_it_plays_once() {
        let back = |mode| [0.0, 0.5, 2.5].map(|time| played_time(mode, -1.0, 0.0, time, 2.0));
        assert_eq!(back(LoopMode::Clamp), [2.0, 1.5, 0.0]);
        assert_eq!(back(LoopMode::Once), [2.0, 1.5, 0.0]);
        assert_eq!(back(LoopMode::Loop), [0.0, 1.5, 1.5]);
        assert_eq!(back(LoopMode::PingPong), [0.0, 0.5, 1.5]);
        assert_eq!(played_time(LoopMode::Loop, 3.0, 0.25, 0.5, 2.0), 1.75);
    }

    #[test]
    fn nothing_escapes_the_clip() {
        for mode in [LoopMode::Once, LoopMode::Loop, LoopMode::PingPong, LoopMode::Clamp] {
            for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, f64::MAX, -0.0, 1e-320] {
                for duration in [0.0, -1.0, f64::NAN, f64::INFINITY, 0.1, f64::MAX, 1e-310] {
                    let inside = clip_time(mode, time, duration);
                    let end = if duration.is_finite() { duration.max(0.0) } else { 0.0 };
                    assert!((0.0..=end).contains(&inside), "{mode:?} {time} {duration}: {inside}");
                }
            }
        }
    }
}
