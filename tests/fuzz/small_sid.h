/* A small SID file.
 * SPDX-License-Identifier: BSD-3-Clause */
#ifndef TEST_SMALL_SID_H
#define TEST_SMALL_SID_H

/* As other programs write it: exponents of Fortran, unit and diagonal matrices, blanks in between.
 */
static const char test_small_sid[] =
    "    2   1    :No. nodes, No. modes: by hand\r\n part\r\n"
    "      new modal                                 =\r\n           refmod\r\n"
    "                mass                            = 2.00000000000D+00\r\n"
    "                nelastq                         =     1\r\n"
    "                ielastq (   1)                  = Eigen Mode    1 :        9.089 Hz\r\n"
    "           end refmod\r\n           frame\r\n"
    "new node = 7\nrframe = body ref\norigin\norder = 1\nnrow = 3\nncol = 1\nnq = 1\nnqn = 0\n"
    "structure = 3\nend origin\nphi\norder=0\nnrow=3\nncol=1\nnq=1\nnqn=0\nstructure=0\nend phi\n"
    "psi\norder=0\nnrow=3\nncol=1\nnq=1\nnqn=0\nstructure=0\nend psi\n"
    "AP\norder=1\nnrow=3\nncol=3\nnq=1\nnqn=0\nstructure=4\nend AP\nend node\n"
    "new node = 9\norigin\norder = 1\nnrow = 3\nncol = 1\nnq = 1\nnqn = 0\nstructure = 3\n"
    "m0( 1, 1) = 1.0D+00\nm1( 2, 1, 1) = 1.0D+00\nend origin\n"
    "phi\norder=0\nnrow=3\nncol=1\nnq=1\nnqn=0\nstructure=3\nm0( 2, 1)= 1\nend phi\n"
    "end node\nend frame\n"
    "mdCM\norder=1\nnrow=3\nncol=1\nnq=1\nnqn=0\nstructure=3\nm0(1,1)=1\nm1(2,1,1)=0.5\nend mdCM\n"
    "J\norder=1\nnrow=6\nncol=1\nnq=1\nnqn=0\nstructure=3\nm0(2,1)=1\nm0(3,1)=1\n"
    "m1(4,1,1)=-0.5\nend J\n"
    "Ct\norder=0\nnrow=1\nncol=3\nnq=1\nnqn=0\nstructure=3\nm0(1,2)=0.5\nend Ct\n"
    "Cr\norder=1\nnrow=1\nncol=3\nnq=1\nnqn=0\nstructure=3\nm0(1,3)=0.5\nend Cr\n"
    "Me\norder=0\nnrow=1\nncol=1\nnq=1\nnqn=0\nstructure=4\nend Me\n"
    "Oe\norder=1\nnrow=1\nncol=6\nnq=1\nnqn=0\nstructure=3\nm0(1,4)=0.5\nm1(1,1,1)=-1\n"
    "m1(1,1,3)=-1\nend Oe\n"
    "ksigma\norder=0\nnrow=1\nncol=1\nnq=1\nnqn=0\nstructure=0\nend ksigma\n"
    "Ke\norder=0\nnrow=1\nncol=1\nnq=1\nnqn=0\nstructure=1\nm0(1,1)=3.0d1\nend Ke\n"
    "end modal\nend part\n";

#endif
