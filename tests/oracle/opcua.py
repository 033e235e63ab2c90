"""What a gateway says over OPC UA, as a client sees it that knows the standard and nothing of the gateway.

    opcua.py values URL
    opcua.py nodes URL
    opcua.py follow URL

`values` browses the machine below Objects and reads every variable, all in one request. The answer is JSON: of each
variable its value, status and source time stamp. `nodes` also reads what describes each of them, and what the server
says of itself, and tries everything that would change something, which has to change nothing.

`follow` subscribes to the alarms of the server and to the variable `condition`, and writes what comes as lines of JSON,
after a line once it has subscribed. For each line that it reads it asks for what stands (ConditionRefresh), and writes
how that was answered.
"""

import asyncio
import json
import sys
from datetime import datetime, timezone

from asyncua import Client, ua


def status(code):
    return ua.status_codes.get_name_and_doc(code.value)[0]


def micros(stamp):
    return None if stamp is None else round(stamp.replace(tzinfo=timezone.utc).timestamp() * 1e6)


def plain(value):
    if isinstance(value, datetime):
        return micros(value)
    if isinstance(value, ua.LocalizedText):
        return value.Text
    if isinstance(value, ua.NodeId):
        return value.to_string()
    if isinstance(value, ua.StatusCode):
        return status(value)
    return value.hex() if isinstance(value, bytes) else value


async def machine_of(client):
    for it in await client.nodes.objects.get_children():
        if (await it.read_browse_name()).Name == "machine":
            return it
    raise AssertionError("there is no machine below Objects")


async def variables(node, owner=""):
    """Name, node and owner of all variables below `node`."""
    found = []
    for it in await node.get_children_descriptions():
        name, child = it.BrowseName.Name, node.new_node(node.session, it.NodeId)
        if it.NodeClass == ua.NodeClass.Object:
            found += await variables(child, name)
        elif it.NodeClass == ua.NodeClass.Variable:
            found.append((name, child, owner))
    return found


def plainly(value):
    held = value.Value.Value if value.Value is not None else None
    return {"value": plain(held), "status": status(value.StatusCode), "source": micros(value.SourceTimestamp)}


async def told(name, node, owner, value):
    properties = {(await it.read_browse_name()).Name: await it.read_value() for it in await node.get_properties()}
    unit, choices = properties.get("EngineeringUnits"), properties.get("EnumStrings")
    kind = await node.read_data_type_as_variant_type()
    held = value.Value.Value if value.Value is not None else None
    assert held is None or value.Value.VariantType in (kind, ua.VariantType.DateTime), (name, value, kind)
    return {
        **plainly(value),
        "unit": "" if unit is None else unit.DisplayName.Text,
        "code": None if unit is None else unit.UnitId,
        "choices": choices and [it.Text for it in choices],
        "type": await type_of(node),
        "meaning": (await node.read_description()).Text,
        "owner": owner,
        "writable": ua.AccessLevel.CurrentWrite in await node.get_user_access_level(),
    }


async def type_of(node):
    """Name of the type of a variable, by the server's own nodes of the standard."""
    definition = (await node.get_references(ua.ObjectIds.HasTypeDefinition, ua.BrowseDirection.Forward))[0]
    return definition.BrowseName.Name


async def refused(awaited):
    try:
        answer = await awaited
        return str(answer)
    except ua.UaError as error:
        return type(error).__name__


async def deleted(client, node):
    _, codes = await client.delete_nodes([node])
    return [status(it) for it in codes]


async def attempts(client, machine, node):
    one = ua.DataValue(ua.Variant(1, ua.VariantType.Int64))
    return [
        await refused(node.write_value(one)),
        await refused(node.write_attribute(ua.AttributeIds.DisplayName, ua.DataValue(ua.LocalizedText("x")))),
        await refused(machine.call_method(ua.NodeId("none", machine.nodeid.NamespaceIndex))),
        await refused(machine.add_variable(ua.NodeId("new", machine.nodeid.NamespaceIndex), "new", 1)),
        await refused(deleted(client, node)),
        await refused(node.read_raw_history(numvalues=1)),
    ]


async def read_values(url):
    async with Client(url, timeout=20) as client:
        own = await variables(await machine_of(client))
        values = await client.uaclient.read_attributes([node.nodeid for _, node, _ in own], ua.AttributeIds.Value)
        return {"values": {node.nodeid.Identifier: plainly(value) for (_, node, _), value in zip(own, values)}}


async def read_nodes(url):
    async with Client(url, timeout=20) as client:
        machine = await machine_of(client)
        own = await variables(machine)
        nodes = [node.nodeid for _, node, _ in own]
        values = await client.uaclient.read_attributes(nodes, ua.AttributeIds.Value)
        listed = {node.nodeid.Identifier: await told(name, node, owner, value)
                  for (name, node, owner), value in zip(own, values)}
        tried = await attempts(client, machine, own[0][1])
        again = await client.uaclient.read_attributes(nodes, ua.AttributeIds.Value)
        # The clock of the test stands, so that nothing ages between the two.
        assert [(it.Value, it.StatusCode) for it in values] == [(it.Value, it.StatusCode) for it in again]
        endpoints = await client.get_endpoints()
        return {
            "values": listed,
            "namespace": (await client.get_namespace_array())[machine.nodeid.NamespaceIndex],
            "endpoints": [[it.EndpointUrl, it.SecurityPolicyUri.rpartition("#")[2]] for it in endpoints],
            "attempts": tried,
        }


class Writer:
    """Writes what the server tells."""

    def event_notification(self, event):
        own = {name: value for name, value in vars(event).items() if name not in event.internal_properties}
        fields = {name: plain(value) for name, value in own.items()}
        say(event=fields)

    def datachange_notification(self, node, value, data):
        item = data.monitored_item.Value
        say(change=plain(value), status=status(item.StatusCode), source=micros(item.SourceTimestamp))

    def status_change_notification(self, change):
        say(subscription=str(change.Status))


def say(**what):
    print(json.dumps(what, default=str), flush=True)


async def follow(url):
    async with Client(url, timeout=20) as client:
        subscription = await client.create_subscription(100, Writer())
        # What is refreshed begins and ends with events of its own.
        types = [ua.ObjectIds.AlarmConditionType, ua.ObjectIds.RefreshStartEventType, ua.ObjectIds.RefreshEndEventType]
        # The server keeps as many events as are asked for, and does not know the filter that would be made by itself.
        await subscription.subscribe_events(ua.ObjectIds.Server, types, queuesize=32, where_clause_generation=False)
        machine = await machine_of(client)
        condition = [it for it in await machine.get_children() if (await it.read_browse_name()).Name == "condition"][0]
        await subscription.subscribe_data_change(condition)
        say(ready=True)
        conditions = client.get_node(ua.ObjectIds.ConditionType)
        method = ua.NodeId(ua.ObjectIds.ConditionType_ConditionRefresh)
        while await asyncio.get_running_loop().run_in_executor(None, sys.stdin.readline):
            asked = conditions.call_method(method, ua.Variant(subscription.subscription_id, ua.VariantType.UInt32))
            say(refresh=await refused(asked))


if __name__ == "__main__":
    what, url = sys.argv[1:]
    if what == "follow":
        asyncio.run(follow(url))
    else:
        read = read_values if what == "values" else read_nodes
        json.dump(asyncio.run(read(url)), sys.stdout, default=str)
