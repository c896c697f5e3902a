!> What to use instead of the words of FEAP that this program does not have. doc/manual/feap.md
!! lists these words for users.
!!
!! Source: the manual of FEAPpv, and the manual of FEAP for words that decks often contain. SPRIng
!! is in neither manual, but users often try it.
module deck_feap
  use base_text, only: key_of
  implicit none
  private
  public :: mesh_hint, command_hint, property_hint

  type :: advice_t
    character(29) :: words !! the first four letters of each word, separated by a space
    character(120) :: hint
  end type advice_t

  !> Words that FEAP has in the mesh part.
  !&< keeps the rows where they are
  type(advice_t), parameter :: MESH_WORDS(*) = [ &
    advice_t('angl cang ceul eang eule tria', &
      'nodes have no axes of their own; rotate the body so that its supports lie ' &
        //'along the axes (TRANsform, or ROTAte of PATCh)'), &
    advice_t('base cbas ebas', 'MOVE prescribes the motion of supports'), &
    advice_t('blen side snod', &
      'curved bodies are read by PATCh with FILE, by NPATch, or by MESH'), &
    advice_t('body', 'BODY FORCe is a record of MATErial'), &
    advice_t('btem temp', 'there are no temperatures'), &
    advice_t('cdam damp', &
      'there are no dampers; TRANsient,HHT and TRANsient,BACK dissipate energy'), &
    advice_t('cmas mpro', 'there are no point masses; DENSity of MATErial gives the mass'), &
    advice_t('coun', 'nodes and elements are counted automatically; remove this word'), &
    advice_t('cpro', 'EPROportional and FPROportional choose the load table of a node'), &
    advice_t('csti spri stif', 'there are no springs; use elements with a small modulus'), &
    advice_t('debu', 'every deck is checked; remove this word'), &
    advice_t('elin link slav', &
      'TIE joins nodes at the same position, and CONStraint of MESH ties a node to others'), &
    advice_t('ereg regi', &
      'there are no regions; give each body its own PATCh, or its own material'), &
    advice_t('flex', 'every body is flexible, except a PATCh or SPLIne of TYPE RIGId'), &
    advice_t('foll', 'PRESsure with FOLLower follows the surface'), &
    advice_t('glob', &
      'the control record gives ndm and ndf; SMALl or FINIte of MATErial chooses the strains'), &
    advice_t('join', 'TIE joins nodes at the same position; there are no other joints'), &
    advice_t('lfor', 'FORCe, EFORce and CFORce load nodes, and PRESsure loads faces'), &
    advice_t('load', &
      'FORCe, EFORce and CFORce load nodes, and PRESsure loads faces; PROP defines ' &
        //'how loads vary in time'), &
    advice_t('manu', 'there is no interactive input; remove this word'), &
    advice_t('mass', &
      'there are no point masses; DENSity of MATErial gives the mass, and MASS is ' &
        //'a command between BATCh and END'), &
    advice_t('moda', &
      'a body is elastic, or a PATCh or SPLIne of TYPE RIGId; modes are not computed'), &
    advice_t('nblo nsid', 'NPATch takes the control points of a whole solid'), &
    advice_t('nopa pars', 'expressions are always evaluated; remove this word'), &
    advice_t('orde', 'METIS orders the equations; remove this word'), &
    advice_t('peri', &
      'there are no periodic conditions; CONStraint of MESH ties a node to others'), &
    advice_t('pola', &
      'COORdinates take expressions, such as r*cosd(30); TRANsform rotates and shifts nodes'), &
    advice_t('reac', 'FORCe loads nodes; REAC is a command between BATCh and END'), &
    advice_t('read', 'INCLude reads another file'), &
    advice_t('rese', 'CBOUndary, and EBOUndary with SET, replace the restraints of nodes'), &
    advice_t('rigi', 'a rigid body is a PATCh or SPLIne of TYPE RIGId'), &
    advice_t('rota', 'ROTAte is a record of PATCh, MESH and SPLIne; TRANsform rotates nodes'), &
    advice_t('save', &
      'records of the mesh cannot be saved; INCLude reads them from a file, and ' &
        //'SAVE is a command between BATCh and END'), &
    advice_t('sblo', 'BLOCk makes hexahedra in a mapped region'), &
    advice_t('shif', 'TRANslate of PATCh and MESH shifts a body, and TRANsform shifts nodes'), &
    advice_t('sloa', &
      'PRESsure loads faces of bodies, and CSURface a surface that is given by points'), &
    advice_t('sphe', &
      'COORdinates take expressions, such as r*cosd(30); HEMIsphere of PATCh is ' &
        //'half of a hollow sphere'), &
    advice_t('spin', &
      'there are no centrifugal forces, as BODY FORCe of MATErial is constant; ' &
        //'MOVE with ROTAte turns a body'), &
    advice_t('swee', 'MOVE with ROTAte prescribes a rotation'), &
    advice_t('titl', 'the title follows the word FEAP in the first record; remove this word') ]
  !&>

  !> Words that FEAP has in the solution part.
  !&< keeps the rows where they are
  type(advice_t), parameter :: COMMANDS(*) = [ &
    advice_t('acce', 'accelerations are not printed; DISP prints displacements'), &
    advice_t('acti deac', 'parts of a body cannot be added or removed'), &
    advice_t('back', 'AUTO repeats a failed step in smaller steps'), &
    advice_t('base', 'MOVE prescribes the motion of supports'), &
    advice_t('beta', 'TRANsient chooses the scheme of time integration'), &
    advice_t('bfgs', &
      'UTAN,LINE,1 searches along the increment; FACTor REUSe uses earlier factors as a ' &
      //'preconditioner'), &
    advice_t('chec', 'every deck is checked before it is solved; bezel --check only checks it'), &
    advice_t('comm', 'comments begin with !'), &
    advice_t('cont', 'contact is found anew in each iteration; remove this word'), &
    advice_t('damp', &
      'there is no damping matrix; TRANsient,HHT and TRANsient,BACK dissipate energy'), &
    advice_t('data', &
      'give the values in the DT and TOL commands themselves; INCLude reads another file'), &
    advice_t('debu echo show', 'the log lists what was read and done; remove this word'), &
    advice_t('dire iter meth', 'FACTor chooses how linear systems are solved'), &
    advice_t('eige eigv subs', &
      'eigenvalues are not computed; the report counts the negative pivots of the tangent'), &
    advice_t('else endi if  ', &
      'there are no conditions; a LOOP around TANG ends when the iteration has converged'), &
    advice_t('erro', 'errors are not estimated; compare two meshes'), &
    advice_t('expl', &
      'time integration is implicit: TRANsient,BACK, TRANsient,NEWMark or TRANsient,HHT'), &
    advice_t('geom', 'TANG includes the geometric stiffness of FINIte strains; remove this word'), &
    advice_t('hist manu', 'there is no interactive input; remove this word'), &
    advice_t('iden', 'eigenvalues are not computed; remove this word'), &
    advice_t('init', 'bodies start at rest, with zero displacements'), &
    advice_t('jint', &
      'J integrals are not computed; COHEsive of CONTact gives bonds a fracture energy'), &
    advice_t('line', 'the material law decides whether a body is linear: ELAStic ISOTropic is'), &
    advice_t('list', 'CURVe defines a table of quantities'), &
    advice_t('mesh', &
      'the mesh cannot change during the solution; PROP, MOVE and DISPlacement ' &
        //'change loads and motions'), &
    advice_t('moda', 'modes are not computed; TRANsient integrates in time'), &
    advice_t('newf', &
      'loads that must stay constant need a load table of their own: PROP, ' &
        //'FPROportional and EPROportional'), &
    advice_t('nonl', 'the material law decides whether a body is nonlinear: ELAStic NEOHook is'), &
    advice_t('ntan', 'TANG and UTAN form the tangent of all elements'), &
    advice_t('outm', 'the result file contains the mesh, and the log lists what was read'), &
    advice_t('paus', 'a run never waits for input; remove this word'), &
    advice_t('quit', 'END ends the commands, and STOP ends the deck'), &
    advice_t('read', 'RESTart continues from a checkpoint; INCLude reads another file'), &
    advice_t('renu', 'METIS orders the equations; remove this word'), &
    advice_t('resi', 'FORM forms the residual'), &
    advice_t('scre', 'bezel --quiet shows less on the screen'), &
    advice_t('tie ', 'TIE belongs before BATCh'), &
    advice_t('velo', 'velocities are not printed; DISP prints displacements'), &
    advice_t('writ', 'PLOT and OUTPut write fields, and SAVE writes a checkpoint'), &
    advice_t('zero', 'write a separate deck for another analysis') ]
  !&>

  !> Records that FEAP has in MATErial.
  !&< keeps the rows where they are
  type(advice_t), parameter :: PROPERTIES(*) = [ &
    advice_t('angl', 'materials are isotropic and have no axes'), &
    advice_t('axis plan', 'models are three-dimensional (ndm = 3)'), &
    advice_t('cree plas visc', 'the only laws are ELAStic ISOTropic and ELAStic NEOHook'), &
    advice_t('damp', 'there is no damping; TRANsient,HHT and TRANsient,BACK dissipate energy'), &
    advice_t('four ther', 'there are no temperatures'), &
    advice_t('geom', 'FINIte strains include the geometric stiffness; remove this record'), &
    advice_t('mass', 'MASS is a command between BATCh and END; DENSity gives the mass'), &
    advice_t('mixe', 'ENHAnced elements lock much less than DISPlacement elements'), &
    advice_t('nonl', 'use FINIte with ELAStic NEOHook for large deformations'), &
    advice_t('pres', 'PRESsure is a word of the mesh part, not a record of MATErial'), &
    advice_t('quad', 'QUADrature is a record of PATCh') ]
  !&>

contains

  !> What to use in place of a word of FEAP's mesh part; empty if the table has no such word.
  pure function mesh_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    hint = advice(MESH_WORDS, word)
  end function mesh_hint

  !> What to use in place of a word of FEAP's solution part; empty if the table has no such word.
  pure function command_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    hint = advice(COMMANDS, word)
  end function command_hint

  !> What to use in place of a record of FEAP's MATErial; empty if the table has no such word.
  pure function property_hint(word) result(hint)
    character(*), intent(in) :: word
    character(:), allocatable :: hint

    hint = advice(PROPERTIES, word)
  end function property_hint

  !> The hint of the row that contains the word; empty if no row does.
  pure function advice(table, word) result(hint)
    type(advice_t), intent(in) :: table(:)
    character(*), intent(in) :: word
    character(:), allocatable :: hint
    integer :: i, at

    hint = ''
    do i = 1, size(table)
      do at = 1, len_trim(table(i)%words), 5
        if (table(i)%words(at:at + 3) /= key_of(word)) cycle
        hint = 'not available here; '//trim(table(i)%hint)
        return
      end do
    end do
  end function advice

end module deck_feap
