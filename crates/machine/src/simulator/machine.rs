//! The machine without its bus.

use super::ailing::Ailing;
use super::disturbance::{Disturbance, Misread};
use super::load_steps::SteppedLoads;
use super::options::Options;
use super::tables::{Gangway, SensorTable, Tables, Thermal};
use super::top::TopSensor;
use super::trail::Trail;
use crate::controller::{Commands, Controller, LookUp, Readings, State};
use crate::hexapod::{FrameMotion, Hexapod, Legs, Pose, PoseRate};
use crate::plant::{CYLINDERS, Cylinder, CylinderState, Inputs, Plant, Wear};
use crate::sea::{GRAVITY, Motion, Sea, SeaError, Spectrum};
use crate::transducer::{Reading, Transducer};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

/// Why a machine cannot exist.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MachineError {
    #[error("the sea cannot exist: {0}")]
    Sea(#[from] SeaError),
    #[error(
        "a sea of {height} m and {period} s moves the cylinders by {stroke:.2} m within an hour, \
         and they have {limit} m; take a calmer sea"
    )]
    Rough { height: f64, period: f64, stroke: f64, limit: f64 },
}

/// Stream of the seed for the sea.
const SEA_STREAM: u64 = u64::MAX;
/// Stream of the seed for the noise of the sensors.
const SENSOR_STREAM: u64 = u64::MAX - 1;
/// Stream of the seed for the timers of transducers, separate for the same reason.
const TIMER_STREAM: u64 = u64::MAX - 4;
/// Stream of the seed for the noise of the spools' positions.
const SPOOL_STREAM: u64 = u64::MAX - 5;
/// Stream of the seed for the sensor on the deck.
const TOP_STREAM: u64 = u64::MAX - 6;
/// Stream of the seed for disturbances of readings, separate so that they change nothing else.
const MISREAD_STREAM: u64 = u64::MAX - 3;

/// Stream of the seed for sudden changes of the loads.
const LOAD_STREAM: u64 = u64::MAX - 7;

/// Everything that can be measured at Sync.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    pub motion: Motion,
    /// C1 and C2 of each cylinder.
    pub transducers: [[Reading; 2]; CYLINDERS],
    /// How long before the Sync each of them was sampled, s; 0 where the Sync asks for it.
    pub ages: [[f64; 2]; CYLINDERS],
    /// P_bot and P_rod of each cylinder, bar.
    pub chambers: [[f64; 2]; CYLINDERS],
    /// P_L (3-4) of each cylinder, bar.
    pub load_pressures: [f64; CYLINDERS],
    /// Spool positions, −1 to 1.
    pub spools: [f64; CYLINDERS],
    /// Supply pressure, bar.
    pub supply: f64,
    /// Roll and pitch of the deck by a sensor on it, rad; 0 without one.
    pub top: [f64; 2],
}

/// Sea, vessel, controller, plant and transducers.
#[derive(Clone, Debug)]
pub struct Machine {
    sea: Sea,
    hexapod: Hexapod,
    controller: Controller,
    plant: Plant,
    transducers: [[Transducer; 2]; CYLINDERS],
    sensors: SensorTable,
    area_ratio: f64,
    loads: [f64; CYLINDERS],
    gangway: Gangway,
    disturbance: Disturbance,
    stepped: Option<SteppedLoads>,
    ailing: Ailing,
    thermal: Option<Thermal>,
    /// β of (3-8), 1/s.
    leakage: f64,
    trail: Trail,
    motion: Motion,
    /// Spool positions of the previous cycle and of this one.
    spools: [[f64; CYLINDERS]; 2],
    /// Sub-steps under the command of the previous cycle, and under this one's.
    sub_steps: [u32; 2],
    rng: ChaCha8Rng,
    misreads: ChaCha8Rng,
    spool_noise: ChaCha8Rng,
    /// The sensor on the deck, if there is one.
    top: Option<TopSensor>,
    /// Times between the readings of the transducers that send by timers of their own, s; 0 for others.
    timers: [[f64; 2]; CYLINDERS],
    ages: ChaCha8Rng,
    sample: u64,
    sample_time: f64,
}

impl Machine {
    /// The machine of `tables` in the state that `options` ask for.
    ///
    /// # Errors
    /// The sea cannot exist, or is too rough for the cylinders.
    pub fn new(tables: &Tables, sample_time: f64, options: &Options) -> Result<Self, MachineError> {
        let random = |stream| {
            let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
            rng.set_stream(stream);
            rng
        };
        let [height, period] = options.sea.unwrap_or([tables.sea.height, tables.sea.period]);
        let spectrum = Spectrum::new(height, period, tables.sea.peakedness)?;
        let sea = Sea::new(&spectrum, &tables.vessel, sample_time, &mut random(SEA_STREAM));
        let hexapod = Hexapod::new(&tables.hexapod);
        refuse_rough(&sea, &hexapod, &spectrum, tables.controller.stroke_limit)?;
        let sub_steps = options.sub_steps.max(1);
        let sub_step = sample_time / f64::from(sub_steps);
        let late = ((tables.controller.latency / sub_step).round() as u32).min(sub_steps);
        let parameters = tables.plant();
        let retracted = parameters.cylinder.ends[0];
        let built = tables.disturbance.valve.map(|valve| parameters.with_valve(valve));
        let plant = Plant::new(built.as_ref().unwrap_or(&parameters), sub_step, retracted);
        let weights = weights(&hexapod);
        let loads = parameters.spread.load;
        let look_ups = std::array::from_fn(|leg| {
            let measured = Cylinder::new(&parameters, leg, sub_step);
            let pressure = measured.balance(0.0, loads[leg], weights[leg]);
            LookUp::of(
                &measured,
                tables.controller.speed_limit,
                pressure,
                parameters.supply.pressure,
            )
        });
        let mut machine = Self {
            motion: sea.motion(),
            sea,
            controller: Controller::new(
                &tables.controller,
                hexapod.clone(),
                look_ups,
                retracted,
                sample_time,
                options.start,
            ),
            hexapod,
            plant,
            transducers: std::array::from_fn(|leg| {
                [&tables.c1, &tables.c2]
                    .map(|errors| Transducer::new(&tables.transducer, errors, leg, sample_time))
            }),
            sensors: tables.sensors,
            area_ratio: parameters.cylinder.area_ratio,
            loads,
            gangway: tables.gangway,
            disturbance: tables.disturbance,
            stepped: tables
                .disturbance
                .load_steps
                .map(|table| SteppedLoads::new(table, random(LOAD_STREAM))),
            ailing: Ailing::new(&options.ailments),
            thermal: tables.thermal,
            leakage: parameters.cylinder.leakage,
            trail: Trail::new(tables.sensors.valve_age.into_iter().fold(0.0, f64::max), sub_step),
            spools: [[0.0; CYLINDERS]; 2],
            sub_steps: [late, sub_steps - late],
            rng: random(SENSOR_STREAM),
            misreads: random(MISREAD_STREAM),
            spool_noise: random(SPOOL_STREAM),
            top: None,
            timers: [[0.0; 2]; CYLINDERS],
            ages: random(TIMER_STREAM),
            sample: 0,
            sample_time,
        };
        machine.settle(options.start);
        Ok(machine)
    }

    /// The same with transducers that send by timers of their own, with these times between their readings,
    /// s; 0 for those that answer the Sync.
    pub fn with_timers(self, timers: [[f64; 2]; CYLINDERS]) -> Self {
        Self { timers, ..self }
    }

    /// The same with the sensor on the deck, of the seed of its `options`.
    pub fn with_top(mut self, options: &Options) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(options.seed);
        rng.set_stream(TOP_STREAM);
        self.top = Some(TopSensor::new(self.sensors.top, &self.hexapod, self.sample_time, rng));
        self
    }

    /// Puts the cylinders where they stand in `state`, as if they had been there for long.
    fn settle(&mut self, state: State) {
        let [lengths, speeds] = match state {
            State::Safe | State::Settled => return,
            State::Neutral => [[0.0; CYLINDERS]; 2],
            State::Engaged => {
                let reference = self.controller.engaged(&self.motion.pose, &self.motion.rate);
                [reference.lengths, reference.speeds]
            }
        };
        let spools = self.controller.spools(&speeds);
        let inputs = self.inputs(spools);
        for leg in 0..CYLINDERS {
            let acceleration = inputs.accelerations[leg];
            let pressure =
                self.plant.cylinders()[leg].balance(lengths[leg], inputs.loads[leg], acceleration);
            let (length, speed, spool) = (lengths[leg], speeds[leg], spools[leg]);
            self.plant.states_mut()[leg] =
                CylinderState { length, speed, pressure, spool, imbalance: 0.0 };
        }
        self.spools = [spools; 2];
    }

    pub fn request(&mut self, state: State) {
        self.controller.request(state);
    }

    /// The platform's state, as the PLC reports it.
    pub fn state(&self) -> State {
        self.controller.state()
    }

    /// True states of the cylinders at the present time.
    pub fn states(&self) -> &[CylinderState; CYLINDERS] {
        self.plant.states()
    }

    /// The length of the cylinder `leg`, from 0, as its noiseless C1 would read it now, m.
    pub fn calibrated(&self, leg: usize) -> f64 {
        self.transducers[leg][0].calibrated(self.time(), self.states()[leg].length)
    }

    /// Motion of the vessel at the present time.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Supply pressure, bar.
    pub fn supply_pressure(&self) -> f64 {
        self.plant.supply_pressure()
    }

    pub fn hexapod(&self) -> &Hexapod {
        &self.hexapod
    }

    /// Measures everything; called once a cycle.
    pub fn sample(&mut self) -> Sample {
        let mut sample = Sample { motion: self.motion, ..Sample::default() };
        let time = self.time();
        for leg in 0..CYLINDERS {
            let state = self.plant.states()[leg];
            let misreads = self.disturbance.readings(time, &mut self.misreads);
            for (which, Misread { late, counts }) in misreads.into_iter().enumerate() {
                // The timer knows nothing of the Sync.
                let timer = self.timers[leg][which];
                let age = if timer > 0.0 { self.ages.random_range(0.0..timer) } else { 0.0 };
                sample.ages[leg][which] = age;
                sample.transducers[leg][which] = self.transducers[leg][which].read(
                    time,
                    [state.length, state.speed],
                    [late - age, counts],
                    &mut self.rng,
                );
            }
            let (valve, supply) = self.trail.at(&self.plant, leg, self.sensors.valve_age[leg]);
            let chambers = self.plant.cylinders()[leg].chamber_pressures(&valve, supply);
            let [bottom, rod] = chambers.map(|pressure| {
                let noise: f64 = StandardNormal.sample(&mut self.rng);
                (pressure + self.sensors.pressure * noise).max(0.0)
            });
            sample.chambers[leg] = [bottom, rod];
            sample.load_pressures[leg] = bottom - self.area_ratio * rod;
            sample.spools[leg] = valve.spool;
            if self.sensors.spool > 0.0 {
                let noise: f64 = StandardNormal.sample(&mut self.spool_noise);
                sample.spools[leg] += self.sensors.spool * noise;
            }
        }
        if let Some(top) = &mut self.top {
            let strokes = self.plant.states().map(|state| state.length);
            sample.top = top.read(&self.hexapod, &self.motion.pose, &strokes);
        }
        let noise: f64 = StandardNormal.sample(&mut self.rng);
        sample.supply = self.plant.supply_pressure() + self.sensors.supply * noise;
        sample
    }

    /// The controller's commands for its readings. They act from [`Machine::advance`] on.
    pub fn command(&mut self, readings: &Readings) -> Commands {
        let commands = self.controller.step(readings);
        let before = self.spools[1];
        let time = self.time();
        let [told, bands] = self.ailing.told(time, &commands.spools);
        self.spools = [before, self.disturbance.spools(time, &before, &told, &bands)];
        commands
    }

    /// Advances to the next Sync.
    pub fn advance(&mut self) {
        let mut inputs = self.inputs(self.spools[0]);
        self.trail.run(&mut self.plant, &inputs, self.sub_steps[0]);
        inputs.spools = self.spools[1];
        self.trail.run(&mut self.plant, &inputs, self.sub_steps[1]);
        self.sea.advance();
        self.motion = self.sea.motion();
        self.sample += 1;
        let time = self.time();
        if let Some(stepped) = &mut self.stepped {
            stepped.advance(time, self.sample_time);
        }
    }

    /// Time since the first cycle, s.
    fn time(&self) -> f64 {
        self.sample as f64 * self.sample_time
    }

    /// Inputs of the cylinders at the present time. Each stands on the vessel, so its own frame
    /// accelerates.
    fn inputs(&self, spools: [f64; CYLINDERS]) -> Inputs {
        let Motion { pose, acceleration, .. } = &self.motion;
        let legs = Legs::new(&self.hexapod, pose, &self.hexapod.neutral());
        let lift = acceleration.translation + Vector3::new(0.0, 0.0, GRAVITY);
        let turn = pose.angular_velocity(acceleration);
        let phase = self.time() * TAU / self.gangway.period;
        let load = self.disturbance.load(self.time());
        Inputs {
            spools,
            loads: std::array::from_fn(|leg| {
                let bearing = leg as f64 * TAU / CYLINDERS as f64;
                let stepped = self.stepped.as_ref().map_or(1.0, |it| it.factor(leg));
                let slewed = 1.0 + self.gangway.load * (phase - bearing).cos();
                load * stepped * self.loads[leg] * slewed
            }),
            accelerations: std::array::from_fn(|leg| {
                legs.directions[leg].dot(&(lift + turn.cross(&legs.base_arms[leg])))
            }),
            pump_lost: self.disturbance.pump_lost(self.time()),
            supply_lost: self.ailing.supply_lost(self.time()),
            wear: self.ailing.wear(self.time(), self.usual_wear()),
        }
    }

    /// What the temperature of the oil changes at the present time.
    fn usual_wear(&self) -> Wear {
        let Some(thermal) = self.thermal else { return Wear::default() };
        let part = thermal.part(self.time());
        Wear {
            viscosity: -part * thermal.viscosity,
            leakage: part * thermal.leakage * self.leakage,
            flow: part * thermal.flow,
            overlap: part * thermal.overlap,
            ..Wear::default()
        }
    }
}

/// Gravity along the cylinders in the neutral state, m/s².
fn weights(hexapod: &Hexapod) -> [f64; CYLINDERS] {
    Legs::new(hexapod, &Pose::default(), &hexapod.neutral())
        .directions
        .map(|direction| GRAVITY * direction.z)
}

/// Refuses a sea whose largest stroke in an hour, by Rayleigh's distribution, exceeds `limit`, m.
fn refuse_rough(
    sea: &Sea,
    hexapod: &Hexapod,
    spectrum: &Spectrum,
    limit: f64,
) -> Result<(), MachineError> {
    let (calm, deck, still) = (Pose::default(), hexapod.neutral(), PoseRate::default());
    let legs = Legs::new(hexapod, &calm, &deck);
    let (height, period) = (spectrum.height(), spectrum.period());
    let waves = 3600.0 / period;
    let stroke = (0..CYLINDERS)
        .map(|leg| {
            // Strokes are to small motions what their velocities are to rates.
            let stroke = |pose: &Pose| {
                let rate = PoseRate { translation: pose.translation, attitude: pose.attitude };
                let base = FrameMotion { pose: &calm, rate: &rate };
                legs.velocities(base, FrameMotion { pose: &deck, rate: &still })[leg]
            };
            sea.deviation(stroke) * (2.0 * waves.ln()).sqrt()
        })
        .fold(0.0, f64::max);
    if stroke > limit {
        return Err(MachineError::Rough { height, period, stroke, limit });
    }
    Ok(())
}
