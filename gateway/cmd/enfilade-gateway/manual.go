// SPDX-License-Identifier: Apache-2.0

package main

import (
	"flag"
	"fmt"
	"strings"
)

// manual returns the manual page, for man(7), made of what --help says.
func manual() string {
	page := &strings.Builder{}
	fmt.Fprintf(page, ".TH ENFILADE\\-GATEWAY 8 \"\" \"Enfilade %s\" \"Enfilade\"\n", version)
	page.WriteString(".SH NAME\nenfilade\\-gateway \\- Enfilade's API over HTTP, and the dashboard\n")
	page.WriteString(".SH SYNOPSIS\n\\fBenfilade\\-gateway\\fR [\\fIOPTIONS\\fR]\n.SH OPTIONS\n")
	s := defaults()
	flagsOf(&s).VisitAll(func(f *flag.Flag) {
		value, usage := valueOf(f)
		fmt.Fprintf(page, ".TP\n\\fB\\-\\-%s\\fR \\fI%s\\fR\n%s [$%s]\n", roff(f.Name), roff(value), roff(usage),
			environmentOf(f.Name))
	})
	page.WriteString(".SH FILES\n/etc/enfilade/gateway.env\n")
	page.WriteString(".SH SIGNALS\nTERM and INT end the gateway. TLS files are read by themselves when they change.\n")
	page.WriteString(".SH SEE ALSO\n.BR enfilade\\-server (8),\n.BR enfilade (1)\n")
	return page.String()
}

// roff returns text as man(7) prints it unchanged.
func roff(text string) string {
	return strings.NewReplacer("\\", "\\e", "-", "\\-").Replace(text)
}
