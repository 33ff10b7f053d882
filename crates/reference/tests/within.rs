//! Bodies within one another and bodies that overlap, against closed forms.

use glam::DVec3;
use murano_reference::{Ellipsoid, GlassBody, Ray, Shape, Status, World, trace_all};

fn ball(centre: DVec3, radius: f64, ior: f64) -> GlassBody {
    GlassBody::clear(Shape::Ellipsoid(Ellipsoid { centre, radii: DVec3::splat(radius) }), ior)
}

fn world(bodies: Vec<GlassBody>) -> World {
    World { bodies, opaque: None }
}

/// Parallel to +Z at a distance from the axis.
fn ray(height: f64) -> Ray {
    Ray { origin: DVec3::new(0.0, height, -5.0), direction: DVec3::Z }
}

/// n r sin is the same at every interface of balls about one centre, so that the turns add up.
#[test]
fn balls_about_one_centre_turn_light_as_bouguer_says() {
    let (outer, inner) = (1.5, 1.2);
    for (radius, order) in [(0.5, [0, 1]), (0.5, [1, 0]), (0.8, [0, 1])] {
        let bodies = [(1.0, outer), (radius, inner)];
        let world = world(order.map(|i| ball(DVec3::ZERO, bodies[i].0, bodies[i].1)).into());
        for step in 0..95 {
            let height = 0.003 + 0.01 * f64::from(step);
            let within = |ior: f64, radius: f64| (height / (ior * radius)).asin();
            let meets = height / outer < radius;
            let total = meets && height / inner > radius;
            // Away from the axis: in, off or through the inner ball, out.
            let mut away = -2.0 * (height.asin() - within(outer, 1.0));
            if total {
                away += std::f64::consts::PI - 2.0 * within(outer, radius);
            } else if meets {
                away -= 2.0 * (within(outer, radius) - within(inner, radius));
            }
            let chain = trace_all(&world, &ray(height), 8);
            let expected = DVec3::new(0.0, away.sin(), away.cos());
            assert_eq!(chain.status, Status::Left, "{height}");
            assert!(chain.exit.distance(expected) < 1e-9, "{radius} {height}: {} for {expected}", chain.exit);
            assert_eq!(
                chain.bounces,
                if total {
                    3
                } else if meets {
                    4
                } else {
                    2
                }
            );
        }
    }
}

#[test]
fn bodies_of_one_glass_that_overlap_have_no_interface_between_them() {
    let (a, b) = (DVec3::new(0.0, 0.0, -0.3), DVec3::new(0.0, 0.1, 0.4));
    let both = world(vec![ball(a, 1.0, 1.5), ball(b, 0.9, 1.5)]);
    let alone = world(vec![ball(a, 1.0, 1.5)]);
    for step in 0..60 {
        let height = 0.003 + 0.01 * f64::from(step);
        let chain = trace_all(&both, &ray(height), 8);
        assert_eq!(chain.bounces, 2, "{height}");
        // Through the first ball alone, and from where it would leave that straight on to the second one's far side.
        let first = trace_all(&alone, &ray(height), 1);
        let to_far_side = chain.origin - first.origin;
        assert!(to_far_side.normalize().distance(first.exit) < 1e-12, "{height}: straight within both");
        assert!(
            (chain.origin.distance(b) - 0.9).abs() < 1e-12 && (chain.path_length - to_far_side.length()).abs() < 1e-9
        );
    }
}

#[test]
fn the_smaller_of_two_displaces_the_other() {
    // A small ball halfway into a large one: between them, light goes by the small one's index alone.
    let small = ball(DVec3::new(0.0, 0.0, -1.0), 0.3, 1.2);
    let worlds = [
        world(vec![ball(DVec3::ZERO, 1.0, 1.5), small]),
        world(vec![ball(DVec3::new(0.0, 0.0, -1.0), 0.3, 1.2), ball(DVec3::ZERO, 1.0, 1.5)]),
    ];
    for world in &worlds {
        let chain = trace_all(world, &ray(0.0), 8);
        assert_eq!((chain.status, chain.bounces), (Status::Left, 3), "into the small, into the large, out");
        assert!((chain.path_length - 2.3).abs() < 1e-12);
    }
    let [a, b] = worlds.map(|world| trace_all(&world, &ray(0.2), 8));
    assert!(a.exit.distance(b.exit) < 1e-12, "whichever comes first in the list");
}
