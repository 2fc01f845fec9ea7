// A bridge without servos, for measuring the page: it serves the page, says what it has to, and sends 8
// signals 1000 times a second and the others 5 times, with noise, a move each second and limits that act.
'use strict';

const { WebSocketServer } = require('ws');
const fs = require('node:fs');
const http = require('node:http');

const protocol = 'foxglove.websocket.v1';
const rate_Hz = 1000;
const limits = ['current', 'power', 'temperature', 'strain', 'stress', 'slew'];
const parameters = {
  'axis.zero_strain': 0.04,
  'wire.length_m': 0.1,
  'limits.temperature_K': 363,
  'limits.current_A': 0.4,
  'limits.power_W': 2,
  'limits.stress_Pa': 3e8,
  'limits.min_strain': 0.005,
  'limits.max_strain': 0.04,
};

// The same noise in each run.
let seed = 1;
function noise() {
  seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
  return seed / 2 ** 31 - 1;
}
const rounded = (value) => Number(value.toPrecision(7));

function fast(number) {
  const t = number / rate_Hz;
  const goal = Math.floor(t) % 2 ? 0.02 : 0.03;
  const strain = 0.025 + 0.005 * Math.cos(Math.PI * t) + 2e-5 * noise();
  const drive_current_A = 0.2 + 0.1 * Math.sin(Math.PI * t) + 1e-3 * noise();
  return {
    strain: rounded(strain),
    setpoint: rounded(0.1 * (0.04 - goal)),
    reference: rounded(0.1 * (0.04 - goal) * 0.98),
    drive_current_A: rounded(drive_current_A),
    power_W: rounded(12 * drive_current_A ** 2),
    resistance_ohm: rounded(11 + 40 * strain + 2e-3 * noise()),
    wire_temperature_K: rounded(340 + 20 * Math.sin(Math.PI * t + 0.5) + 0.02 * noise()),
    limit_reasons: number % 3000 < 400 ? 1 : number % 7000 < 300 ? 4 : 0,
  };
}
function slow(number) {
  const share = 0.5 + 0.4 * Math.sin((Math.PI * number) / rate_Hz);
  return {
    strain_sd: 2e-4,
    position_m: 1.5e-3,
    current_A: 0.2,
    wanted_power_W: 0.6,
    hot_spot_K: 350,
    estimated_ambient_K: 296,
    resistance_model_ohm: 12,
    martensite: rounded(share),
    r_phase: 0.05,
    stress_Pa: 1.5e8,
    supply_V: 12,
  };
}

// What the service `history` answers, whose last row was now; a bridge would thin it to what was asked for.
function history(seconds) {
  const began_ms = Date.now() - 1000 * seconds;
  const rows = seconds * rate_Hz;
  const answer = { t_ns: [] };
  for (let row = 0; row < rows; ++row) {
    answer.t_ns.push(Math.round((began_ms + (row * 1000) / rate_Hz) * 1e3) * 1e3);
    const sample = { ...slow(row), ...fast(row) };
    for (const key in sample) {
      (answer[key] ??= []).push(sample[key]);
    }
  }
  return { began_ms, rows, json: Buffer.from(JSON.stringify(answer)) };
}

const describe = () => ({
  version: 'synthetic',
  parameters: Object.entries(parameters).map(([name, value]) => ({
    name,
    type: 'number',
    unit: '',
    min: 0,
    max: 1e9,
    default: value,
    change: 'live',
    level: 'tune',
    meaning: name,
  })),
  signals: [...Object.keys(fast(0)), ...Object.keys(slow(0))].map((name) => ({
    name,
    unit: '',
    meaning: name,
    ...(name === 'limit_reasons' ? { bits: limits } : {}),
  })),
  faults: [],
  modes: [{ mode: 1, name: 'profile position', unit: 'um' }],
});
const state = {
  node: 1,
  online: true,
  nmt: 'operational',
  drive: 'operation_enabled',
  statusword: 4663,
  mode: 1,
  mode_name: 'profile position',
  target: 1000,
  position_um: 998.2,
  target_reached: true,
  active: [],
  latched: [],
  warnings: [],
  blocking: [],
  first_cause: null,
  limits: [],
  freeze_frame: null,
  transaction: { state: 'none' },
  unsaved: false,
  rate_hz: rate_Hz,
  gaps: 0,
};
const bridge = {
  bus: 'synthetic',
  read_only: false,
  nodes: [{ node: 1, name: 'smaservo', online: true, duplicate: false }],
  control: null,
  clients: [],
  activity: null,
  recordings: [],
  trouble: '',
};
const topics = ['/bridge', '/node1/live', '/node1/state'];
const services = ['describe', 'history'];

class Client {
  constructor(socket, past) {
    this.socket = socket;
    this.past = past;
    this.ids = new Map();
    const json = (message) => socket.send(JSON.stringify(message));
    json({
      op: 'serverInfo',
      name: 'synthetic',
      capabilities: ['parameters', 'services'],
      supportedEncodings: ['json'],
      metadata: { version: 'synthetic', client: '1', read_only: 'false' },
    });
    json({
      op: 'advertise',
      channels: topics.map((topic, k) => ({
        id: k + 1,
        topic,
        encoding: 'json',
        schemaName: topic,
        schema: '{}',
      })),
    });
    json({
      op: 'advertiseServices',
      services: services.map((name, k) => ({
        id: k + 1,
        name,
        type: name,
        requestSchema: '{}',
        responseSchema: '{}',
      })),
    });
    socket.on('message', (data, binary) => (binary ? this.call(data) : this.text(JSON.parse(data))));
    this.sent = this.due();
    this.timer = setInterval(() => this.tick(), 5);
    socket.on('close', () => clearInterval(this.timer));
  }

  text(message) {
    if (message.op === 'subscribe') {
      for (const { id, channelId } of message.subscriptions) {
        this.ids.set(topics[channelId - 1], id);
      }
    } else if (message.op === 'getParameters') {
      const all = Object.entries(parameters).map(([name, value]) => ({ name: `node1.${name}`, value }));
      this.socket.send(JSON.stringify({ op: 'parameterValues', parameters: all, id: message.id }));
    }
  }

  call(data) {
    const service = data.readUInt32LE(1);
    const payload = services[service - 1] === 'describe' ? Buffer.from(JSON.stringify(describe())) : this.past.json;
    const head = Buffer.alloc(17);
    head.writeUInt8(3, 0);
    head.writeUInt32LE(service, 1);
    head.writeUInt32LE(data.readUInt32LE(5), 5);
    head.writeUInt32LE(4, 9);
    head.write('json', 13);
    this.socket.send(Buffer.concat([head, payload]));
  }

  due() {
    return Math.floor(((Date.now() - this.past.began_ms) * rate_Hz) / 1000);
  }

  // Sends all samples up to now, each as a message of its own, as the bridge does.
  tick() {
    const due = this.due();
    for (; this.sent < due; ++this.sent) {
      const time_ms = this.past.began_ms + (this.sent * 1000) / rate_Hz;
      this.say('/node1/live', this.sent % 200 ? fast(this.sent) : { ...slow(this.sent), ...fast(this.sent) }, time_ms);
      if (this.sent % 200 === 0) {
        this.say('/node1/state', state, time_ms);
      }
      if (this.sent % 250 === 0) {
        this.say('/bridge', bridge, time_ms);
      }
    }
  }

  say(topic, value, time_ms) {
    const id = this.ids.get(topic);
    if (id === undefined) {
      return;
    }
    const payload = Buffer.from(JSON.stringify(value));
    const head = Buffer.alloc(13);
    head.writeUInt8(1, 0);
    head.writeUInt32LE(id, 1);
    head.writeBigUInt64LE(BigInt(Math.round(time_ms * 1e3)) * 1000n, 5);
    this.socket.send(Buffer.concat([head, payload]));
  }
}

/** Serves a page.html on a free port; resolves with its address. `history_s` of samples come at once. */
function serve(page, history_s) {
  const server = http.createServer((_request, answer) => {
    answer.setHeader('Content-Type', 'text/html; charset=utf-8');
    answer.end(fs.readFileSync(page));
  });
  const past = history(history_s);
  const sockets = new WebSocketServer({ server, handleProtocols: () => protocol });
  sockets.on('connection', (socket) => new Client(socket, past));
  return new Promise((done) => {
    server.listen(0, '127.0.0.1', () => done(`http://127.0.0.1:${server.address().port}/`));
  });
}

module.exports = { serve };
