//! What a host application of Sparkplug B gets, and what becomes of it while the broker is away.

use crate::metrics_support::Bench;
use crate::modbus::{self, DELAY, Values, offset};
use crate::mqtt::{Kept, plan, publisher};
use serde_json::{Value, json};
use std::time::Duration;
use tertius::appliance::outputs::StateServer;
use tertius::appliance::outputs::modbus::ModbusServer;
use tertius::appliance::outputs::mqtt::{EdgeNode, MqttPlan};
use tertius::appliance::telemetry::points::{Point, PointKind, Points};
use tertius::appliance::telemetry::snapshot::Snapshot;
use tertius_testing::broker::Broker;
use tertius_testing::machine::{estimating, gateway_of};
use tertius_testing::oracle::Peer;

fn sparkplug(plan: MqttPlan) -> MqttPlan {
    let edge = EdgeNode { group: "ship".to_owned(), node: "gangway".to_owned() };
    MqttPlan { sparkplug: Some(edge), ..plan }
}

/// A host application, which asserts by itself what the standard asks of the order of messages.
struct Host(Peer);

impl Host {
    fn new(broker: &Broker) -> Self {
        let port = broker.port.to_string();
        let host = Self(Peer::start("sparkplug.py", &[&port, "ship"]));
        host.find(|it| it["ready"] == true);
        host
    }

    /// The next message for which `is` holds.
    #[track_caller]
    fn find(&self, is: impl Fn(&Value) -> bool) -> Value {
        loop {
            let line = self.0.next_line();
            assert!(line.get("wrong").is_none(), "{line}");
            if is(&line) {
                return line;
            }
        }
    }

    /// The births of the node and of its devices.
    fn births(&self) -> Vec<Value> {
        let node = self.find(|it| it["kind"] == "NBIRTH");
        let devices = node["metrics"]["cylinders"]["value"].as_u64().expect("a number");
        let devices = (0..devices).map(|_| self.find(|it| it["kind"] == "DBIRTH"));
        std::iter::once(node).chain(devices).collect()
    }

    fn command(&mut self, name: &str) {
        self.0.tell(&format!("gangway\t{name}"));
    }
}

/// What a host knows of `point` after `births`.
fn metric<'a>(births: &'a [Value], point: &Point) -> &'a Value {
    let own = point.name.get(..10).filter(|it| it.starts_with("cylinder_"));
    let birth = births.iter().find(|it| it["device"].as_str() == own).expect("it was born");
    let name = own.map_or(point.name.as_str(), |own| &point.name[own.len() + 1..]);
    &birth["metrics"][name]
}

/// Compares what a host knows after `births` with what a master reads over Modbus.
#[track_caller]
fn say_the_same(births: &[Value], read: &Value) {
    let points = Points::new(&Snapshot::unknown(modbus::CYLINDERS));
    for point in points.all() {
        let (name, told) = (&point.name, metric(births, point));
        let (value, register) = (&told["value"], &read[name]);
        let places = |names: &[&str]| {
            let place = |word: &str| names.iter().position(|it| *it == word).map(|it| it as u64);
            value.as_str().map(|word| place(word).unwrap_or_else(|| panic!("{name}: {word}")))
        };
        let (kind, said) = match point.kind {
            PointKind::Whole => ("INT64", value.as_u64()),
            PointKind::Choice(names) => ("STRING", places(names)),
            PointKind::Time => ("DATETIME", value.as_u64().map(|it| it / 1000)),
            PointKind::Real => {
                let (said, found) = (value.as_f64(), register.as_f64());
                let apart = said.zip(found).map(|(said, found)| (said - found).abs());
                let same = apart.map_or(said.is_none() && found.is_none(), |apart| apart < 1e-7);
                assert!(same, "{name}: {said:?} {found:?}");
                assert_eq!(
                    (&told["type"], &told["properties"]["engUnit"]),
                    (&json!("DOUBLE"), &json!("m"))
                );
                continue;
            }
        };
        assert_eq!(told["type"], kind, "{name}");
        let unit = Some(point.unit.symbol()).filter(|unit| !unit.is_empty());
        assert_eq!(told["properties"]["engUnit"].as_str(), unit, "{name}");
        assert_eq!(told["properties"]["documentation"], point.meaning, "{name}");
        // In the registers what is not known has a number of its own, and so has what there is none of.
        let missing = [0, 65_535, 4_294_967_295];
        let found = register.as_u64().unwrap_or_else(|| panic!("{name}: {register}"));
        match said {
            Some(said) => assert_eq!(said, found, "{name}"),
            None => assert!(missing.contains(&found), "{name}: {found}"),
        }
    }
}

#[test]
fn a_host_knows_what_a_master_reads_from_birth_to_death() {
    let folder = tempfile::tempdir().expect("there is room");
    let broker = Broker::start(folder.path(), "");
    let mut bench = Bench::new();
    bench.gateway = gateway_of(estimating(), 0.9);
    let listen = "127.0.0.1:0".parse().expect("an address");
    let master = ModbusServer::start(listen, &bench.witness.recorder).expect("a free port");
    bench.witness.recorder.opened();
    bench.run(&modbus::cycles(0..120), DELAY);
    let mut host = Host::new(&broker);
    let plan = sparkplug(MqttPlan { period: Duration::from_secs(3600), ..plan(&broker, None) });
    let running = publisher(plan.clone(), &bench.witness.recorder);
    let births = host.births();
    assert_eq!(births.len(), 7);
    say_the_same(&births, &Values::read(&master).0);
    let cylinder = &births[2]["metrics"];
    assert_eq!(
        (&births[2]["device"], &cylinder["c1"]["value"]),
        (&json!("cylinder_2"), &json!("healthy"))
    );
    let node = &births[0]["metrics"];
    assert_eq!((&node["bdSeq"]["value"], &node["condition"]["value"]), (&json!(0), &json!("ok")));
    assert_eq!(node["Node Control/Rebirth"]["value"], false);
    assert_eq!(node["Node Control/Rebirth"]["type"], "BOOLEAN");

    // A step is told at once, and no more than what is new; the numbers wait for their period.
    bench.run(&offset(120..150, 30), DELAY);
    let is_of_cylinder = |it: &Value| it["kind"] == "DDATA" && it["device"] == "cylinder_2";
    let told = host.find(is_of_cylinder);
    let metrics = told["metrics"].as_object().expect("metrics");
    assert_eq!(metrics["c1"]["value"], "faulty", "{told}");
    assert!(
        !["r1", "estimate", "raised_fde2"].iter().any(|it| metrics.contains_key(*it)),
        "{told}"
    );
    assert!(metrics["c1"]["properties"].as_object().is_some_and(|it| it.is_empty()), "{told}");

    // Only a rebirth is followed, and that once a second at most.
    host.command("Node Control/Reboot");
    host.command("condition");
    host.command("raw\tFFFFFFFF");
    let ignored = |it: &Value| it["metrics"]["commands_ignored"]["value"].as_u64();
    host.find(|it| it["kind"] == "NDATA" && ignored(it) == Some(3));
    std::iter::repeat_with(|| host.command("Node Control/Rebirth")).take(5).for_each(drop);
    let births = host.births();
    say_the_same(&births, &Values::read(&master).0);
    assert_eq!(births[0]["metrics"]["bdSeq"]["value"], 0, "the connection is the same");
    host.find(|it| ignored(it) == Some(7));

    // Numbers of which nothing is known are null, and not what they were.
    for _ in 0..70 {
        bench.hands.pass(tertius::time::Span::from_seconds(0.02));
        bench.turn().expect("the bus is up");
    }
    let told = host.find(|it| is_of_cylinder(it) && it["metrics"].get("estimate").is_some());
    assert_eq!(told["metrics"]["estimate"]["value"], Value::Null, "{told}");

    // The next connection has the next number, and each death that of its own.
    drop(running);
    assert_eq!(host.find(|it| it["kind"] == "NDEATH")["metrics"]["bdSeq"]["value"], 0);
    let again = publisher(plan, &bench.witness.recorder);
    say_the_same(&host.births(), &Values::read(&master).0);
    drop(again);
    host.find(|it| it["kind"] == "NDEATH");
}

#[test]
fn events_of_an_outage_are_forwarded_in_order_as_history() {
    let folder = tempfile::tempdir().expect("there is room");
    // The standard has them sent with QoS 0, of which a broker keeps none for who is away unless it is told to.
    let mut broker = Broker::start(folder.path(), "queue_qos0_messages true\n");
    let mut kept = Kept::new();
    let plan = sparkplug(plan(&broker, Some(&kept.path())));
    let host = Host::new(&broker);
    let _running = publisher(plan, &kept.recorder);
    kept.minute(0);
    let each = kept.at_least(1 + kept.incidents.len() + 2).len() - 1;
    let receive = |from: i64, last: i64, history: bool| {
        let (mut news, mut newest) = (Vec::new(), from);
        while newest < last {
            let message = host.find(|it| it["metrics"]["event"]["value"].is_string());
            let metric = &message["metrics"]["event"];
            let text = metric["value"].as_str().expect("text");
            let event: Value = serde_json::from_str(text).expect("JSON");
            let (at, told) = (event["at_s"].as_f64(), metric["at"].as_f64());
            assert!((at.expect("s") * 1e3 - told.expect("ms")).abs() <= 1.0, "{message}");
            assert!(metric["historical"] == true || !history, "{message}");
            let number = event["number"].as_i64().expect("a number");
            if number > newest {
                newest = number;
                news.push(event);
            }
        }
        news
    };
    let so_far = 1 + each as i64;
    assert_eq!(receive(0, so_far, false), kept.news());
    broker.stop();
    (1..30).for_each(|minute| kept.minute(minute));
    let all = kept.at_least(1 + each * 30);
    broker.restart();
    assert_eq!(receive(so_far, all.len() as i64, true), all[1 + each..]);
    kept.clerk.finish();
}
