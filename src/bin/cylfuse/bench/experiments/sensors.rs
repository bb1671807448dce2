//! Random single cylinders before every sensor of the twin.

use crate::bench::Bench;
use crate::bench::methods::{Errors, Method, errors_of, fit};
use crate::bench::page::{Csv, Section, digits, paragraph};
use crate::bench::sample::Sample;
use crate::bench::stage;
use crate::failure::Failure;
use cylfuse::twin::{ActiveStereo, DepthSensor, Kind, TimeOfFlight, random_scene};

const METHODS: [Method; 4] = [Method::Ransac, Method::Paper, Method::Default, Method::NoEdges];

fn sensors() -> [(&'static str, DepthSensor); 3] {
    [
        ("structured light", stage::structured_light()),
        ("time of flight", DepthSensor::TimeOfFlight(TimeOfFlight::default())),
        ("active stereo", DepthSensor::ActiveStereo(ActiveStereo::default())),
    ]
}

fn frames(bench: &Bench) -> usize {
    bench.scale.of(24, 3, 1)
}

pub fn count(bench: &Bench) -> usize {
    sensors().len() * frames(bench)
}

pub fn run(bench: &Bench) -> Result<Section, Failure> {
    let jobs: Vec<(usize, usize)> =
        (0..sensors().len()).flat_map(|sensor| (0..frames(bench)).map(move |k| (sensor, k))).collect();
    let rows = bench.map(&jobs, |(sensor, k)| {
        // All sensors see the same scenes.
        let seed = bench.seed(24, *k);
        let scene = random_scene(Kind::Single, seed)?;
        let options = stage::capture_options(sensors()[*sensor].1)?;
        let sample = Sample::take(String::new(), &scene, &options, [seed, seed])?;
        Ok((*sensor, *k, METHODS.map(|method| errors_of(fit(&sample, method).as_ref()))))
    })?;
    let mut csv = Csv::new("sensors", "sensor,scene,method,E_o_deg,E_p_mm,E_r_pct,E_l_pct");
    for (sensor, k, errors) in &rows {
        for (method, errors) in METHODS.iter().zip(errors) {
            let name = method.name().replace(',', "");
            csv.push(&format!("{},{k},{name},{}", sensors()[*sensor].0, errors.map(digits).join(",")));
        }
    }
    let mut named = Vec::new();
    for (sensor, (name, _)) in sensors().iter().enumerate() {
        for (k, method) in METHODS.iter().enumerate() {
            let own = rows.iter().filter(|(other, _, _)| *other == sensor);
            let errors: Vec<Errors> = own.map(|(_, _, errors)| errors[k]).collect();
            named.push((format!("{name}, {}", method.name()), errors));
        }
    }
    let body = paragraph(&format!(
        "{} random scenes of one cylinder (can, bar or tube, radius 15 to 60 mm, any direction, 0.55 to 0.95 m, any paint), \
         each taken by the three sensors of the twin. Centre and length count where both ends are seen.",
        frames(bench)
    )) + &super::summary_table("sensor, method", &named);
    Ok(Section { name: "sensors", title: "Sensors".into(), body, numbers: vec![csv], said: None })
}
