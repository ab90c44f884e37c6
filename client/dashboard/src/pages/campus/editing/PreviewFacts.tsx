// SPDX-License-Identifier: Apache-2.0
import { problemOf } from '../../../api/errors';
import { misfit, moveText, sentencesOf } from '../../../graph/preview';
import { Badge } from '../../../ui/Badge';
import type { Preview } from './usePreview';

const SHOWN = 8;

interface Props {
  preview: Preview;
  titleOf: (name: string) => string;
  // Takes a link point out of the graph; undefined: it cannot be.
  suspend: (name: string) => (() => void) | undefined;
}

// What saving would do: maps that move, link points that are switched off, and how well all of it fits.
export function PreviewFacts({ preview: { effects, error, isCurrent }, titleOf, suspend }: Props) {
  if (error !== undefined) {
    return (
      <section className="inspector-part" aria-label="Preview">
        <h2>What it would do</h2>
        <p className="refusal" role="alert">
          {problemOf(error).title}: {problemOf(error).text}
        </p>
      </section>
    );
  }
  if (!effects) return <p role="status">Working out what it would do …</p>;
  const { moves, residuals, chi2Before, chi2After, degreesOfFreedom } = effects;
  return (
    <section className="inspector-part" aria-label="Preview" aria-busy={!isCurrent}>
      <h2>What it would do</h2>
      <div role="status">
        <ul className="effects">
          {sentencesOf(effects, titleOf).map(({ tone, text }) => (
            <li key={text}>
              <Badge tone={tone}>{text}</Badge>
            </li>
          ))}
        </ul>
      </div>
      <dl className="facts">
        <dt>Chi-squared</dt>
        <dd>
          {chi2Before.toFixed(1)} → {chi2After.toFixed(1)} <span className="sub">({degreesOfFreedom} degrees of freedom)</span>
        </dd>
      </dl>
      {residuals.length > 0 && (
        <ul className="residuals" aria-label="Link points that disagree">
          {residuals.slice(0, SHOWN).map((one) => {
            const act = one.switchedOffAfter ? undefined : suspend(one.linkPoint);
            return (
              <li key={one.linkPoint}>
                <span>
                  {titleOf(one.linkPoint)} <span className="sub">{one.switchedOffAfter ? `switched off, ${misfit(one)}` : misfit(one)}</span>
                </span>
                {act && (
                  <button className="button" aria-label={`Suspend ${titleOf(one.linkPoint)}`} onClick={act}>
                    Suspend
                  </button>
                )}
              </li>
            );
          })}
        </ul>
      )}
      {moves.length > 0 && (
        <details>
          <summary>Maps that move</summary>
          <ul className="residuals">
            {moves.slice(0, SHOWN).map((move) => (
              <li key={move.map}>
                {titleOf(move.map)} <span className="sub">{moveText(move)}</span>
              </li>
            ))}
            {moves.length > SHOWN && <li className="sub">and {moves.length - SHOWN} more</li>}
          </ul>
        </details>
      )}
    </section>
  );
}
