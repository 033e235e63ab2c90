"""A host application of Sparkplug B, by the messages of Eclipse's own definition and a client of its own.

    sparkplug.py PORT GROUP

Subscribes to everything of the group and writes each message as a line of JSON, after a line once it has subscribed. What
the standard asks of the order of messages is asserted: a birth of the node before everything else, births of its devices
before their data, numbers without a gap, and a death with the number of its birth. For each line of its input it sends a
command to the node: the name of a metric, which is set to true, or `raw` and bytes in hexadecimal.
"""

import json
import sys
import threading

import paho.mqtt.client as mqtt
from google.protobuf.unknown_fields import UnknownFieldSet
from pysparkplug._datatype import DataType
from pysparkplug._protobuf import Payload

port, group = int(sys.argv[1]), sys.argv[2]
lock = threading.Lock()
# Of the node: the number of its birth, the number of its newest message, and the devices that are born.
state = {"connection": None, "seq": None, "devices": set()}


def say(**what):
    with lock:
        print(json.dumps(what), flush=True)


def value_of(metric):
    field = metric.WhichOneof("value")
    assert metric.is_null == (field is None), metric
    if field is None:
        return None
    datatype = DataType(metric.datatype)
    assert field == datatype.field, (metric, datatype)
    decoded = datatype.decode(getattr(metric, field))
    return round(decoded.timestamp() * 1000) if hasattr(decoded, "timestamp") else decoded


def told(metric):
    properties = {key: it.string_value for key, it in zip(metric.properties.keys, metric.properties.values)}
    assert len(metric.properties.keys) == len(metric.properties.values), metric
    assert all(it.type == DataType.STRING for it in metric.properties.values), metric
    return {
        "value": value_of(metric),
        "type": DataType(metric.datatype).name,
        "at": metric.timestamp,
        "historical": metric.is_historical,
        "properties": properties,
    }


def follow(kind, device, payload, metrics):
    """What the standard asks of the order (5 and 6.4)."""
    if kind == "NDEATH":
        assert not payload.HasField("seq"), payload
        # With QoS 1 it may come twice.
        assert state["connection"] in (None, metrics["bdSeq"]["value"]), (metrics, state)
        state.update(connection=None, seq=None, devices=set())
        return
    assert payload.HasField("timestamp") and all(it.HasField("timestamp") for it in payload.metrics), payload
    if kind == "NBIRTH":
        assert payload.seq == 0, payload
        state.update(connection=metrics["bdSeq"]["value"], seq=0, devices=set())
        return
    assert state["connection"] is not None, (kind, "before a birth")
    state["seq"] = (state["seq"] + 1) % 256
    assert payload.seq == state["seq"], (kind, payload.seq, state)
    if kind == "DBIRTH":
        state["devices"].add(device)
    if kind == "DDATA":
        assert device in state["devices"], (device, state)


def on_message(client, _, message):
    try:
        space, of_group, kind, node, *device = message.topic.split("/")
        assert space == "spBv1.0" and of_group == group and len(device) <= 1, message.topic
        if kind == "NCMD":
            return
        device = device[0] if device else None
        assert (device is not None) == kind.startswith("D"), message.topic
        assert not message.retain, message.topic
        assert message.qos == (1 if kind == "NDEATH" else 0), (message.topic, message.qos)
        payload = Payload()
        payload.ParseFromString(message.payload)
        assert len(UnknownFieldSet(payload)) == 0, "fields that the standard does not have"
        assert all(len(UnknownFieldSet(it)) == 0 for it in payload.metrics), "the same of a metric"
        names = [it.name for it in payload.metrics]
        assert len(names) == len(set(names)), names
        metrics = {it.name: told(it) for it in payload.metrics}
        follow(kind, device, payload, metrics)
        say(kind=kind, node=node, device=device, seq=payload.seq, at=payload.timestamp, metrics=metrics)
    except Exception as error:
        say(wrong=f"{type(error).__name__}: {error}")


# A session that outlives both ends, for a broker that is away.
client = mqtt.Client("host", clean_session=False, protocol=mqtt.MQTTv311)
client.reconnect_delay_set(min_delay=1, max_delay=1)
client.on_connect = lambda it, *_: it.subscribe(f"spBv1.0/{group}/#", qos=1)
client.on_subscribe = lambda *_: say(ready=True)
client.on_message = on_message
client.connect("localhost", port)
client.loop_start()
for line in sys.stdin:
    node, name, *bytes_of = line.split("\t")
    if name == "raw":
        body = bytes.fromhex(bytes_of[0])
    else:
        payload = Payload()
        metric = payload.metrics.add()
        metric.name, metric.datatype, metric.boolean_value = name.strip(), DataType.BOOLEAN, True
        body = payload.SerializeToString()
    client.publish(f"spBv1.0/{group}/NCMD/{node}", body, qos=1)
