#!/usr/bin/env node
// Another party's CANopen stack (npm package `canopen`) as master or as slave, on a bus of lines:
// a line from standard input is what was heard in one cycle ("203#0F000000 080#"), the line given
// back is what was said, and words for the test: "!done", "!wrong:...". See other_stack_test.cpp.
//   usage: other_stack.js master|slave FOLDER_WITH_node_modules
'use strict';

const Module = require('module');
const path = require('path');
const readline = require('readline');

// The package computes the CRC of block transfers by a native module, which would have to be
// compiled; blocks are not transferred here.
const load = Module._load;
Module._load = function (name, ...rest) {
  return name === 'node-crc' ? { crc: () => { throw new Error('no block transfers'); } }
                             : load.call(this, name, ...rest);
};
const canopen = require(path.resolve(process.argv[3], 'node_modules', 'canopen'));
const { AccessType, DataType, Device, ObjectType } = canopen;

const kNode = 3;
const kHost = 127;
let said = [];
const say = (word) => said.push('!' + word.replace(/\s+/g, '_'));

function hex(message) {
  const id = message.id.toString(16).padStart(3, '0');
  return `${id}#${Buffer.from(message.data || []).toString('hex')}`.toUpperCase();
}

function attach(device) {
  device.addListener('message', (message) => said.push(hex(message)));
  const lines = readline.createInterface({ input: process.stdin });
  lines.on('line', async (line) => {
    for (const word of line.split(' ').filter(Boolean)) {
      const [id, data] = word.split('#');
      const bytes = Buffer.from(data, 'hex');
      device.receive({ id: parseInt(id, 16), data: bytes, len: bytes.length });
    }
    for (let i = 0; i < 3; ++i) await new Promise((resolve) => setImmediate(resolve));
    process.stdout.write(said.join(' ') + '\n');
    said = [];
  });
  lines.on('close', () => process.exit(0));
}

function add(device, index, dataType, value, accessType = AccessType.READ_WRITE) {
  const entry = device.eds.addEntry(index, { parameterName: `o${index.toString(16)}`, dataType, accessType });
  entry.value = value;
  return entry;
}

function addRecord(device, index, values, dataType) {
  const entry = device.eds.addEntry(index, { parameterName: `o${index.toString(16)}`, objectType: ObjectType.RECORD });
  values.forEach((value, i) => {
    const sub = entry.addSubObject(i + 1, {
      parameterName: `s${i + 1}`, dataType, accessType: AccessType.READ_WRITE });
    sub.value = value;
  });
  return entry;
}

// ---- its master, our simulated drive

async function master() {
  const device = new Device({ id: kHost });
  attach(device);
  device.eds.addSdoClientParameter(kNode, 0x600 + kNode, 0x580 + kNode);
  device.eds.addEmcyConsumer(0x80 + kNode);
  device.eds.addHeartbeatConsumer(kNode, 60000);
  device.eds.setSyncCobId(0x80);
  const status = add(device, 0x2041, DataType.UNSIGNED16, 0);
  const position = add(device, 0x2064, DataType.INTEGER32, 0);
  const torque = add(device, 0x2077, DataType.INTEGER16, 0);
  device.eds.addReceivePdo({ cobId: 0x180 + kNode, transmissionType: 1, dataObjects: [status, position, torque] });
  const word = add(device, 0x2040, DataType.UNSIGNED16, 0);
  const target = add(device, 0x2071, DataType.INTEGER16, 0);
  device.eds.addTransmitPdo({ cobId: 0x200 + kNode, transmissionType: 255, dataObjects: [word, target] });
  let emergency = null;
  device.emcy.on('emergency', ({ em }) => { emergency = em.code; });
  let state = null;
  device.nmt.on('heartbeat', (beat) => { state = beat.state; });
  device.start();
  device.nmt._handleNmt(0x01);

  const check = (what, found, expected) => {
    if (found !== expected) say(`wrong:${what} is ${found}, expected ${expected}`);
  };
  const read = (index, subIndex, dataType) =>
    device.sdo.upload({ serverId: kNode, index, subIndex, dataType, timeout: 10000 });
  const write = (index, subIndex, data, dataType) =>
    device.sdo.download({ serverId: kNode, index, subIndex, data, dataType, timeout: 10000 });
  const aborts = async (what, promise, code) => {
    try {
      await promise;
      say(`wrong:${what} was not aborted`);
    } catch (error) {
      check(what, Number(error.code), code);
    }
  };
  const until = async (what, done) => {
    for (let i = 0; i < 20000; ++i) {
      if (done()) return;
      await new Promise((resolve) => setImmediate(resolve));
    }
    say(`wrong:waited in vain for ${what}`);
  };
  const U8 = DataType.UNSIGNED8, U16 = DataType.UNSIGNED16, U32 = DataType.UNSIGNED32;

  check('0x1000', (await read(0x1000, 0, U32)) & 0xFFFF, 0x192);
  check('0x6076', await read(0x6076, 0, U32), 280);
  check('0x608F:1', await read(0x608F, 1, U32), 16384);
  check('0x6091:1', await read(0x6091, 1, U32), 100);
  await aborts('no object', read(0x5FFF, 0, U32), 0x06020000);
  await aborts('no sub-index', read(0x6091, 9, U32), 0x06090011);
  await aborts('read only', write(0x6041, 0, 1, U16), 0x06010002);
  await aborts('length', write(0x6072, 0, 1, U32), 0x06070010);
  await write(0x1800, 1, 0x80000180 + kNode, U32);
  await write(0x1800, 2, 1, U8);
  await write(0x1A00, 0, 0, U8);
  await write(0x1A00, 1, 0x60410010, U32);
  await write(0x1A00, 2, 0x60640020, U32);
  await write(0x1A00, 3, 0x60770010, U32);
  await aborts('not mappable', write(0x1A00, 4, 0x60760020, U32), 0x06040041);
  await write(0x1A00, 0, 3, U8);
  await write(0x1800, 1, 0x180 + kNode, U32);
  await write(0x1400, 1, 0x80000200 + kNode, U32);
  await write(0x1400, 2, 1, U8);
  await write(0x1600, 0, 0, U8);
  await write(0x1600, 1, 0x60400010, U32);
  await write(0x1600, 2, 0x60710010, U32);
  await write(0x1600, 0, 2, U8);
  await write(0x1400, 1, 0x200 + kNode, U32);
  await write(0x1017, 0, 10, U16);
  await write(0x6060, 0, 10, U8);
  check('0x6061', await read(0x6061, 0, U8), 10);
  await until('pre-operational in its heartbeat', () => state === 127);
  device.nmt.startNode(kNode);
  await until('operational in its heartbeat', () => state === 5);

  const command = async (controlword, permille, expected) => {
    word.value = controlword;
    target.value = permille;
    device.pdo.write(0x200 + kNode);
    device.send_sync ? device.send_sync() : device.emit('message', { id: 0x80, data: Buffer.alloc(0) });
    await until(`state ${expected.toString(16)} after ${controlword.toString(16)}`,
                () => (status.value & 0x6F) === expected);
  };
  await command(0x06, 0, 0x21);
  await command(0x07, 0, 0x23);
  await command(0x0F, 0, 0x27);
  await command(0x0F, -250, 0x27);
  await until('its torque', () => torque.value === -250);
  await until('its position', () => position.value === 260759);  // the test turns its shaft to 1 rad
  say('enabled');
  await until('an emergency', () => emergency !== null);  // the test injects an over-current
  check('emergency', Number(emergency), 0x2310);
  await command(0x00, 0, 0x08);
  await command(0x80, 0, 0x40);
  say('done');
}

// ---- its slave, our driver

function slave() {
  const device = new Device({ id: kNode });
  attach(device);
  const U8 = DataType.UNSIGNED8, U16 = DataType.UNSIGNED16, U32 = DataType.UNSIGNED32;
  device.eds.getEntry(0x1000).value = 0x00020192;
  device.eds.setIdentity({ vendorId: 0xDA, productCode: 402, revisionNumber: 7 });
  device.eds.addSdoServerParameter(0, 0x580 + kNode, 0x600 + kNode);
  device.eds.setSyncCobId(0x80);
  add(device, 0x1017, U16, 0);  // the package itself makes 32 bits of it
  addRecord(device, 0x1016, [0], U32);
  add(device, 0x6007, U16, 0);
  const word = add(device, 0x6040, U16, 0);
  const status = add(device, 0x6041, U16, 0x0240, AccessType.READ_ONLY);
  const mode = add(device, 0x6060, DataType.INTEGER8, 0);
  const shown = add(device, 0x6061, DataType.INTEGER8, 0, AccessType.READ_ONLY);
  const position = add(device, 0x6064, DataType.INTEGER32, -123456, AccessType.READ_ONLY);
  const velocity = add(device, 0x606C, DataType.INTEGER32, 16384, AccessType.READ_ONLY);
  const target = add(device, 0x6071, DataType.INTEGER16, 0);
  add(device, 0x6072, U16, 1000);
  add(device, 0x6076, U32, 280, AccessType.READ_ONLY);
  const actual = add(device, 0x6077, DataType.INTEGER16, 0, AccessType.READ_ONLY);
  addRecord(device, 0x608F, [16384, 1], U32);
  addRecord(device, 0x6091, [100, 1], U32);
  add(device, 0x6502, U32, 0x200, AccessType.READ_ONLY);
  device.eds.addReceivePdo({ cobId: 0x200 + kNode, transmissionType: 1, dataObjects: [word, target] });
  device.eds.addTransmitPdo({ cobId: 0x180 + kNode, transmissionType: 1, dataObjects: [status, position, actual] });
  device.eds.addTransmitPdo({ cobId: 0x280 + kNode, transmissionType: 1, dataObjects: [velocity] });
  // The package declares a mapping's count constant; a drive lets its master write it.
  for (const index of [0x1600, 0x1A00, 0x1A01]) device.eds.getEntry(index)[0].accessType = AccessType.READ_WRITE;

  mode.addListener('update', () => { shown.value = mode.value; });
  const obey = () => {
    const w = word.value;
    const state = status.value & 0x6F;
    let next = state;
    if (!(w & 2)) next = 0x40;
    else if ((w & 7) === 6) next = 0x21;
    else if ((w & 0xF) === 7 && state === 0x21) next = 0x23;
    else if ((w & 0xF) === 15 && state === 0x23) next = 0x27;
    status.value = 0x0200 | next;
    actual.value = next === 0x27 ? target.value : 0;
  };
  const receive = device.receive.bind(device);
  device.receive = (message) => {
    receive(message);
    if (message.id === 0x200 + kNode && device.nmt.state === 5) obey();
  };
  device.start();
}

if (process.argv[2] === 'master') {
  master().catch((error) => say(`wrong:${error.stack}`));
} else {
  slave();
}
