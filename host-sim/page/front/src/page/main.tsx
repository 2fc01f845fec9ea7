import 'uplot/dist/uPlot.min.css';
import '../plot/plot.css';
import './style.css';
import { render } from 'preact';
import { start } from '../session/session';
import { watchTrials } from '../session/tuning';
import { App } from './app';
import { listenForStop } from './stop';

start();
watchTrials();
listenForStop();
render(<App />, document.getElementById('page')!);
